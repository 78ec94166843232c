"""After a power cut: what was said to be on the disk is there, and what was not is told from it.

`python -m tests.benchmarks.power_cuts` looks at more states; docs/power-cuts.md has what came of it.
"""

import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from fixtures_db.folder_on_disk import make_folder
from station.files.atomic_file import replace_files
from station.files.mcap_files import StepWriter, read_step
from station.files.sample_files.ros2_samples import Ros2Samples
from station.files.sample_files.sample_file import SampleColumns
from station.files.write_file_pair import write_file_pair
from tests.benchmarks.power_cuts.disk_models import crash_states
from tests.benchmarks.power_cuts.file_operations import ROOT, Entries, FileLog, Resize, Sync, Write
from tests.benchmarks.power_cuts.trial import tried

LEAST_KINDS = {"campaign": 12, "recording": 50, "fixtures": 8}
Synced = Callable[[], list[str]]


@pytest.mark.parametrize("workload", LEAST_KINDS)
def test_after_a_power_cut_nothing_that_was_said_is_lost(workload: str) -> None:
    if shutil.which("strace") is None:
        pytest.skip("no strace here")
    tally = tried(workload, 80, seed=1)
    assert not tally.wrong, tally.first
    assert tally.states >= 80
    assert tally.kinds >= LEAST_KINDS[workload]


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


def test_files_written_into_a_new_folder_have_it_on_the_disk(tmp_path: Path, did: Synced) -> None:
    replace_files({tmp_path / "new" / "a.c": b"a", tmp_path / "new" / "a.h": b"b"})
    assert did()[0] == "fsync ."
    assert did()[-1] == "fsync new"


def test_a_bag_is_on_the_disk_with_the_names_of_its_files(tmp_path: Path, did: Synced) -> None:
    pytest.importorskip("rosbags")
    Ros2Samples(tmp_path / "bag", SampleColumns(("t_s", *"abcdef"), 0, "sensor", is_si=True)).finish()
    assert did()[-1] == "fsync bag"


def test_a_recording_torn_in_its_last_half_second_is_read_up_to_there(tmp_path: Path) -> None:
    path, whole = tmp_path / "r.mcap", 0
    writer = StepWriter(path)
    for number in range(20):
        writer.write_raw(number, bytes([number]) * 2000)
        writer.flush()
        whole = whole or path.stat().st_size * (number == 9)
    content = path.read_bytes()
    writer.close()
    for torn in (bytes(900), content[whole : whole + 20] + bytes(900), bytes(range(256)) * 3):
        path.write_bytes(content[:whole] + torn)
        step = read_step(path)
        assert [at for at, _ in step.raw] == list(range(10))
        assert re.fullmatch(r"the recording was cut short, \d+ bytes at its end are damaged", step.damage or "")


def test_the_models_lose_what_was_not_synced_and_nothing_else() -> None:
    operations = (
        Entries(((ROOT, "a", 1),)), Write(1, 0, bytes([1]) * 512), Sync(1, 2), Sync(ROOT, 3),
        Entries(((ROOT, "b", 2),)), Write(2, 0, bytes([2]) * 1024), Resize(1, 100), Sync(2, 7),
    )  # fmt: skip
    log = FileLog(operations, frozenset({ROOT}))
    states = list(crash_states(log, 1, 200))
    last = [state.files for state in states if state.cut == 7 and state.model == "weak"]
    assert {len(files["a"] or b"") for files in last} == {100, 512}
    assert {len(files) for files in last} == {1, 2}  # the folder was not synced since
    ordered = [state.files for state in states if state.cut == 7 and state.model == "ordered"]
    assert all(files["b"] == bytes([2]) * 1024 for files in ordered)  # any fsync keeps the names before it
    before = [state.files for state in states if state.cut == 5 and state.model == "weak" and "b" in state.files]
    contents = {files["b"] for files in before}
    assert bytes(1024) in contents  # the size without the bytes
    assert bytes(512) + bytes([2]) * 512 in contents  # a sector without the one before it
    assert all(len(files) >= 1 for files in last)
