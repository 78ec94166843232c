"""After a power cut: what was said to be on the disk is there, and what was not is told from it.

`python -m tests.benchmarks.power_cuts` looks at more states; docs/explanation/power-cuts.md has what came of it.
"""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from fixtures_db.folder_on_disk import make_folder
from station.files.mcap_files import StepWriter
from station.files.sample_files.ros2_samples import Ros2Samples
from station.files.sample_files.sample_file import SampleColumns
from station.files.write_file_pair import write_file_pair
from tests.benchmarks.power_cuts.trial import tried

LEAST_KINDS = {"campaign": 12, "recording": 50, "fixtures": 8}
Synced = Callable[[], list[str]]


@pytest.mark.parametrize("number", [20, pytest.param(400, marks=pytest.mark.proof)])
@pytest.mark.parametrize("workload", LEAST_KINDS)
def test_after_a_power_cut_nothing_that_was_said_is_lost(workload: str, number: int) -> None:
    if shutil.which("strace") is None:
        pytest.skip("no strace here")
    tally = tried(workload, number, seed=1)
    assert not tally.wrong, tally.first
    assert tally.states >= min(number, LEAST_KINDS[workload])  # a short workload leaves no more states than that
    assert tally.kinds >= (LEAST_KINDS[workload] if number >= 80 else 2)


@pytest.fixture
def did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Synced:
    """Return what was synced and renamed, in order, by its path in ``tmp_path``."""
    seen = list[str]()

    def noting(name: str) -> None:
        real = getattr(os, name)

        def call(what: int | Path, *more: Path) -> None:
            path = os.readlink(f"/proc/self/fd/{what}") if isinstance(what, int) else more[0]
            seen.append(f"{name} {os.path.relpath(path, tmp_path)}")
            real(what, *more)

        monkeypatch.setattr(os, name, call)

    noting("fsync")
    noting("replace")
    return lambda: seen


def test_a_folder_is_on_the_disk_with_all_that_were_made_above_it(tmp_path: Path, did: Synced) -> None:
    make_folder(tmp_path / "a" / "b" / "c")
    assert did() == ["fsync a/b", "fsync a", "fsync ."]
    make_folder(tmp_path / "a" / "b" / "c")
    assert len(did()) == 3


def test_a_recording_has_its_name_from_its_first_sync_on(tmp_path: Path, did: Synced) -> None:
    writer = StepWriter(tmp_path / "r.mcap")
    writer.flush()
    writer.flush()
    writer.close()
    # as it closes, once for the data and once for the end that says that they are whole
    assert did() == ["fsync r.mcap", "fsync .", *3 * ["fsync r.mcap"]]


def test_the_companion_of_a_file_is_gone_before_the_file_is_replaced(tmp_path: Path, did: Synced) -> None:
    for name in ("out.csv", "out.json"):
        (tmp_path / name).write_text("old")
    with write_file_pair(tmp_path / "out.csv", tmp_path / "out.json") as places:
        for place in places:
            place.write_text("new")
    assert did()[-5:] == ["fsync .", "replace out.csv", "fsync .", "replace out.json", "fsync ."]


def test_a_bag_is_on_the_disk_with_the_names_of_its_files(tmp_path: Path, did: Synced) -> None:
    pytest.importorskip("rosbags")
    Ros2Samples(tmp_path / "bag", SampleColumns(("t_s", *"abcdef"), 0, "sensor", is_si=True)).finish()
    assert did()[-1] == "fsync bag"
