"""What is kept of a computation is what the code says, and only as long as it is that code."""

import os
from pathlib import Path

import numpy as np
import pytest

from procedures import frames
from tests import computed_once
from tests.computed_once import Parts, folder_of_this_code, kept


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    monkeypatch.setattr(computed_once, "WORTH_KEEPING_S", -1.0)
    return []


def test_the_same_question_is_computed_once_also_by_another_process(tmp_path: Path, asked: list[int]) -> None:
    def doubled(values: list[int]) -> list[int]:
        asked.append(len(values))
        return [2 * value for value in values]

    for _ in "ab":  # the second knows what is on the disk alone
        once = kept(doubled, tmp_path / "code", lambda: False)
        first = once([1, 2])
        first.append(99)
        assert once([1, 2]) == [2, 4]  # what the one who asked before did with it is its own
    assert asked == [2]
    assert once([1, 3]) == [2, 6]


def test_what_a_test_replaces_is_not_answered_from_before(
    tmp_path: Path, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def scale() -> float:
        asked.append(1)
        return float(frames.rotation(np.zeros(3))[0, 0])

    once = kept(scale, tmp_path, Parts().have_changed)
    assert [once(), once()] == [1.0, 1.0]
    monkeypatch.setattr(frames, "rotation", lambda vector: np.full((3, 3), 7.0))
    assert [once(), once()] == [7.0, 7.0]
    monkeypatch.undo()
    assert once() == 1.0
    assert len(asked) == 3


def test_what_cannot_be_written_down_is_computed(tmp_path: Path) -> None:
    once = kept(lambda function: function(3), tmp_path, lambda: False)
    assert once(lambda value: value + 1) == 4
    assert not list(tmp_path.iterdir())


def test_code_that_differs_has_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("STATION_TESTS_COMPUTE", raising=False)
    code = tmp_path / "code" / "procedures"
    code.mkdir(parents=True)
    monkeypatch.setattr(computed_once, "ROOT", code.parent)
    folders = []
    for number in range(5):
        (code / "a.py").write_text(f"NUMBER = {number}\n")
        folders.append(folder_of_this_code())
        assert folders[-1] is not None
        os.utime(folders[-1], (number, number))
    assert len(set(folders)) == 5
    assert folder_of_this_code() == folders[-1]
    assert len(list((tmp_path / "cache" / "fog-station-tests").iterdir())) == computed_once.STATES_KEPT
    monkeypatch.setenv("STATION_TESTS_COMPUTE", "1")
    assert folder_of_this_code() is None
