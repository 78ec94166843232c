"""What fails, is skipped or does not end is told by a worker as before; what passed is counted."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT
from tests.worker_messages import is_seen

TESTS = """
import os
import pytest

@pytest.fixture
def breaks():
    raise ValueError("in the set-up")

@pytest.fixture
def breaks_after():
    yield
    raise ValueError("in the teardown")

@pytest.fixture
def prints_after():
    yield
    print("printed in a teardown")

def test_passes(): pass
def test_fails(prints_after): assert 1 == 2
def test_begins_not(breaks): pass
def test_ends_not(breaks_after): pass
@pytest.mark.skip(reason="not here")
def test_is_skipped(): pass
def test_skips(): pytest.skip("nor here")
@pytest.mark.xfail
def test_is_known(): assert 1 == 2
def test_kills_its_worker(): os._exit(3)
def test_comes_after(): pass
"""
CONFTEST = """
from tests.worker_messages import send_what_is_seen

def pytest_configure(config):
    assert send_what_is_seen(config) == hasattr(config, "workerinput")
"""


def test_all_that_does_not_pass_is_told_by_a_worker(tmp_path: Path) -> None:
    (tmp_path / "test_some.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    said = _said(tmp_path)
    (tmp_path / "conftest.py").write_text(CONFTEST)
    told = _said(tmp_path)
    assert told == said
    assert {"2 failed", "3 passed", "2 skipped", "1 xfailed", "2 errors"} <= {*told[-1].split(", ")}, told
    assert any("in the teardown" in each for each in told)
    assert "printed in a teardown" in told


def _said(folder: Path) -> list[str]:
    command = [sys.executable, "-m", "pytest", "-p", "xdist", "-n", "1", "-p", "no:cacheprovider", str(folder)]
    environment = {"PATH": "", "PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    lines = [each for each in done.stdout.splitlines() if each.startswith(("FAILED", "ERROR", "E  ", "printed"))]
    counted = re.search(r"=+ (.*) in [\d.]+s", done.stdout)
    assert counted is not None, done.stdout + done.stderr
    return [*sorted(lines), counted[1]]


@pytest.mark.parametrize("when", ["setup", "call", "teardown"])
def test_a_step_that_did_not_pass_is_seen(when: str) -> None:
    assert all(is_seen("testreport", {"data": {"when": when, "outcome": each}}) for each in ("failed", "skipped"))


def test_what_passed_is_told_once() -> None:
    empty = {"outcome": "passed", "sections": [], "user_properties": []}
    passed = [{**empty, "when": each} for each in ("setup", "call", "teardown")]
    assert [is_seen("testreport", {"data": each}) for each in passed] == [False, True, False]
    said = {"user_properties": [("serial", "7")]}, {"_hypothesis_report": ""}, {"sections": [("in teardown", "x")]}
    assert all(is_seen("testreport", {"data": {**passed[2], **each}}) for each in said)
    assert not is_seen("logstart", {})
    assert is_seen("runtest_protocol_complete", {})
