"""How a certificate falls onto pages: nothing stands alone on the last one."""

import json
import shutil
import subprocess
from collections.abc import Iterator
from functools import cache
from typing import Any

import pytest

from tests.empty_database import empty_db
from tests.station.results.certificate.factory import accepted, drifted, rendered
from tests.station.results.certificate.test_certificate_inputs import made

SIGNED, REMARKS, RECORDS = "Place, date", "7 Remarks", "SHA-256 of the records in the laboratory"


@pytest.fixture(scope="module")
def documents(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the calibrations of a unit, the second of which has one before it."""
    with empty_db(tmp_path_factory.mktemp("db") / "station.db") as database, database.write() as session:
        first, second = (json.loads(accepted(session, drifted(by)).document) for by in (0.0, 2.0))
    return first, second


def pages(html: str) -> list[str]:
    """Return the text of each printed page."""
    try:
        from weasyprint.text.ffi import pango
    except (ImportError, OSError) as error:
        pytest.skip(f"no PDF here: {error}")
    if shutil.which("fc-list") is None:  # the fonts that its lines depend on are not known here
        return list(_pages.__wrapped__(html, ""))
    return _pages(html, f"Pango {pango.pango_version()}, {_fonts()}")


@cache
def _pages(html: str, by: str) -> list[str]:
    """Return the text of each page as it is set ``by`` what this machine has."""
    from weasyprint import HTML

    return [" ".join(_texts(page._page_box)) for page in HTML(string=html).render().pages]  # noqa: SLF001


@cache
def _fonts() -> str:
    found = subprocess.run(["fc-list"], capture_output=True, text=True, check=True).stdout
    return " ".join(sorted(found.splitlines()))


def _texts(box: Any) -> Iterator[str]:
    yield from [box.text] if getattr(box, "text", "") else []
    for child in getattr(box, "children", ()):
        yield from _texts(child)


def lengths(documents: tuple[dict[str, Any], dict[str, Any]]) -> Iterator[str]:
    """Return certificates that end at many heights of a page."""
    first, second = documents
    for count in range(0, 24, 3):
        reported = {
            **second["procedure"],
            "deviations": [f"position {n} was recorded twice" for n in range(count)],
        }
        yield rendered(made({**second, "procedure": reported}))
        files = dict(list(second["inputs"].items())[: count // 2])
        yield rendered(made({**second, "procedure": reported, "inputs": files}, previous=first))


@pytest.fixture(scope="module")
def printed(documents: tuple[dict[str, Any], dict[str, Any]]) -> list[tuple[str, list[str]]]:
    """Return certificates and the pages of each."""
    return [(html, pages(html)) for html in lengths(documents)]


def test_the_signature_shares_its_page_with_the_remarks_and_the_records(
    printed: list[tuple[str, list[str]]],
) -> None:
    for _, (*others, last) in printed:
        assert all(text in last for text in (RECORDS, REMARKS, SIGNED))
        assert not any(SIGNED in page for page in others)
    assert {len(found) for _, found in printed} <= {3, 4, 5}


def test_time_is_traceable_only_as_far_as_it_was_compared(
    documents: tuple[dict[str, Any], dict[str, Any]],
) -> None:
    first, _ = documents
    alone = rendered(made(first))
    assert "compared with no reference" in alone
    assert "their second is that of the device\u2019s own clock" in alone
    row = alone[alone.index("<tr><td>Time</td>") :].partition("</tr>")[0]
    assert "NTP" not in row
    assert "not compared" in row
    assert "stated by the laboratory, the device was not compared with it" in alone
    clock = {"rate_ppm": 12.3, "std_ppm": 0.4}
    timed = rendered(made({**first, "procedure": {**first["procedure"], "clock": clock}}))
    assert "GNSS time, recorded with the counts" in timed
    assert "+12 ppm, u = 0.4 ppm" in timed
    assert "their second is that" not in timed
