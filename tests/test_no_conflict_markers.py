"""No file holds what git leaves where two changes met."""

import subprocess

from tests.paths import ROOT


def test_no_file_holds_a_conflict_that_nobody_resolved() -> None:
    found = subprocess.run(
        ["git", "grep", "-nE", "^(<{7}|>{7}) "], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.stdout == ""
    assert found.returncode == 1, found.stderr  # 1: nothing found
