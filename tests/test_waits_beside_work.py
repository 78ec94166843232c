"""Which file of tests a worker runs next."""

import subprocess
import sys
from pathlib import Path

from tests.patience import HANG_S
from tests.waits_beside_work import COMPUTING, LONGEST, WAITING, following, waits

ROOT = Path(__file__).parents[1]


def test_the_longest_are_there_and_wait() -> None:
    assert all(waits(each, ROOT) for each in LONGEST)


def test_what_computes_though_it_names_a_device_is_there_and_names_one() -> None:
    for each in COMPUTING:
        assert any(word in (ROOT / each).read_text() for word in WAITING), each
        assert not waits(each, ROOT)


def test_one_worker_of_three_waits_and_the_others_compute_from_both_ends(tmp_path: Path) -> None:
    files = {
        "a.py": "",
        "b.py": "from tests.patience import paced",
        "c.py": "",
        "d.py": "SimulatedDevice()",
        "e.py": "",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert [following(list(files), worker, tmp_path) for worker in range(6)] == [
        "b.py", "a.py", "e.py", "b.py", "a.py", "e.py",
    ]  # fmt: skip
    assert following(["a.py", "c.py"], 0, tmp_path) == "a.py"
    assert following(["b.py", "d.py"], 1, tmp_path) == "b.py"


def test_the_longest_begins() -> None:
    another = "tests/station/commands/test_devices.py"
    assert another not in LONGEST
    assert following([another, LONGEST[1], LONGEST[0]], 0, ROOT) == LONGEST[0]


def test_a_worker_that_takes_the_place_of_a_dead_one_runs_what_is_left(tmp_path: Path) -> None:
    others = "".join(f"def test_{each}(): pass\n" for each in "bcd")  # so many that a file is done before the next
    for number in range(2):
        (tmp_path / f"test_{number}.py").write_text("def test_a(): pass\n" + others)
    dies = "    if not DIED.exists():\n        DIED.touch()\n        os._exit(3)\n"
    head = f"import os\nfrom pathlib import Path\nDIED = Path({str(tmp_path / 'died')!r})\ndef test_a():\n"
    (tmp_path / "test_1.py").write_text(head + dies + others)
    hooks = "pytest_xdist_make_scheduler"
    (tmp_path / "conftest.py").write_text(f"from tests.waits_beside_work import {hooks}\n__all__ = ['{hooks}']\n")
    command = [sys.executable, "-m", "pytest", "-p", "xdist", "-n", "1", "--dist", "loadfile", str(tmp_path)]
    environment = {"PATH": "", "PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(
        [*command, "-p", "no:cacheprovider"], cwd=tmp_path, env=environment, capture_output=True, text=True,
        check=False, timeout=HANG_S,
    )  # fmt: skip
    assert "1 failed, 8 passed" in done.stdout, done.stdout + done.stderr  # what it died of is tried again
    assert "crashed while running 'test_1.py::test_a'" in done.stdout
