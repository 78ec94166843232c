"""The report in the browser that shows the screen: behind the server's secret, and able to do nothing."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from urllib.parse import urlsplit

from tests.patience import HANG_S
from tests.station.tui.web.engine import SERVE_REPORT


@contextmanager
def served(report: Path) -> Iterator[str]:
    program = subprocess.Popen(
        [sys.executable, "-P", "-c", SERVE_REPORT, str(report)], stdout=subprocess.PIPE, text=True
    )
    assert program.stdout is not None
    try:
        yield program.stdout.readline().strip()
    finally:
        program.terminate()
        program.communicate()


def got(url: str, path: str, **headers: str) -> tuple[HTTPResponse, bytes]:
    connection = HTTPConnection(urlsplit(url).netloc, timeout=HANG_S)
    connection.request("GET", path, headers=headers)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response, content


def test_it_is_shown_as_it_is_now_and_may_run_nothing(tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    report.write_text("<p>PASS</p>")
    with served(report) as url:
        path = f"{urlsplit(url).path}report"
        response, content = got(url, path)
        assert (response.status, content) == (200, b"<p>PASS</p>")
        assert response.headers["Content-Type"].startswith("text/html")
        policy = response.headers["Content-Security-Policy"]
        assert policy.startswith("sandbox; default-src 'none'")
        assert "script" not in policy
        report.write_text("<p>stored</p>")
        assert got(url, path)[1] == b"<p>stored</p>"


def test_nobody_else_gets_it(tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    report.write_text("gyroscope")
    with served(report) as url:
        path = f"{urlsplit(url).path}report"
        for asked, headers in (
            ("/report", {}),
            ("/wrong/report", {}),
            (path, {"Origin": "http://evil.example"}),
            (path, {"Host": "evil.example"}),
        ):
            response, content = got(url, asked, **headers)
            assert response.status == 403
            assert b"gyroscope" not in content


def test_before_the_verdict_it_says_that_there_is_none(tmp_path: Path) -> None:
    with served(tmp_path / "later" / "report.html") as url:
        response, content = got(url, f"{urlsplit(url).path}report")
    assert response.status == 404
    assert b"there is no report yet" in content
