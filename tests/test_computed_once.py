"""What is kept of a computation is what the code says, and only as long as it is that code."""

import io
import operator
import os
import pickle
import re
from collections.abc import Callable, Collection
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from procedures import frames
from procedures.effects import EFFECTS
from tests import computed_once
from tests.code_behind import PACKAGES, modules_named
from tests.computed_once import Parts, folder_of, kept, pickled
from tests.paths import ROOT


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    monkeypatch.setattr(computed_once, "WORTH_KEEPING_S", -1.0)
    return []


def test_the_same_question_is_computed_once_also_by_another_process(tmp_path: Path, asked: list[int]) -> None:
    def doubled(values: list[int]) -> list[int]:
        asked.append(len(values))
        return [2 * value for value in values]

    for _ in "ab":  # the second knows what is on the disk alone
        once = kept(doubled, tmp_path / "code", lambda besides: False)
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

    parts = Parts()
    once = kept(scale, tmp_path, lambda besides: parts.have_changed(["procedures.frames", *besides]))
    assert [once(), once()] == [1.0, 1.0]
    monkeypatch.setattr(frames, "rotation", lambda vector: np.full((3, 3), 7.0))
    assert [once(), once()] == [7.0, 7.0]
    monkeypatch.undo()
    assert once() == 1.0
    assert len(asked) == 3


def test_what_is_asked_with_an_answer_is_known_from_the_second_run_on(tmp_path: Path, asked: list[int]) -> None:
    def parts(array: np.ndarray) -> list[np.ndarray]:
        return [array, array[::2]]

    def summed(arrays: list[np.ndarray], name: np.ndarray) -> float:
        asked.append(len(arrays))
        return float(sum(map(np.sum, arrays)) + name[0])

    for _ in "ab":  # the second knows what is on the disk alone
        of_parts, of_sums = (kept(each, tmp_path, lambda besides: False) for each in (parts, summed))
        array = np.arange(9.0)
        assert of_sums(of_parts(array), array) == 36.0 + 20.0
    assert asked == [2]


def test_what_cannot_be_written_down_is_computed(tmp_path: Path) -> None:
    once = kept(lambda function: function(3), tmp_path, lambda besides: False)
    assert once(lambda value: value + 1) == 4
    assert not list(tmp_path.iterdir())


def test_what_a_question_names_is_code_that_its_answer_depends_on(tmp_path: Path, asked: list[int]) -> None:
    def called(function: Callable[[float], np.ndarray]) -> float:
        asked.append(1)
        return float(function(0.0)[0])

    besides = list[Collection[str]]()

    def changed(named: Collection[str]) -> bool:
        besides.append(named)
        return len(besides) == 2

    once = kept(called, tmp_path, changed)
    named = import_module("procedures.earth.gravity_and_rate")  # in words: not what this module imports
    assert [once(named.earth_rate_n) for _ in "abc"] == 3 * [0.0]
    assert besides == 3 * [{"procedures.earth.gravity_and_rate"}]
    assert len(asked) == 2  # the second as the code then was


def test_an_effect_of_the_catalogue_is_itself_again_and_one_that_was_changed_is_not_taken_for_it() -> None:
    settling = next(each for each in EFFECTS if each.name == "gyroscope.bias_settling")
    with pytest.raises(pickle.PicklingError):
        pickle.dumps(settling)  # it holds a function without a name
    written = pickled((settling, [settling]))
    assert written is not None
    assert "procedures.effects" in modules_named(written)
    one, [other] = pickle.loads(written)
    assert one is other is settling
    assert pickled(replace(settling, plausible=1.0)) is None


def test_a_path_is_the_same_question_in_each_tests_folder_unless_the_answer_names_it(
    tmp_path: Path, asked: list[int]
) -> None:
    def told(path: Path, of: Callable[[Path], Any]) -> Any:
        asked.append(1)
        return of(path)

    once = kept(told, tmp_path / "answers", lambda besides: False)
    first, second = (Path(f"/dev/shm/pytest-of-me/pytest-{n}/popen-gw{n}/test_a0/imu.csv") for n in (1, 22))
    name = operator.attrgetter("parent.name")
    assert [once(each, name) for each in (first, second)] == ["test_a0"] * 2
    assert len(asked) == 1
    for of in (str, Path):
        assert [once(each, of) for each in (first, second, first)] == [of(first), of(second), of(first)]
    assert len(asked) == 1 + 2 * 3
    others = first.parents[1] / "test_b0" / "imu.csv", first.with_name("gnss.csv"), Path("/test_a0/imu.csv")
    assert [once(each, name) for each in others] == ["test_b0", "test_a0", "test_a0"]
    assert len(asked) == 1 + 2 * 3 + 3


def test_a_model_is_the_same_question_however_its_fields_were_named() -> None:
    class Site(BaseModel):
        latitude: float
        height: float | None = None

    def question(site: Site) -> Any:
        return computed_once._Questions(io.BytesIO()).reducer_override(site)[1]  # noqa: SLF001

    named = Site(height=2.0, latitude=1.0)
    assert question(named)[-1] == ["height", "latitude"]  # of a set, whose order is another in each process
    assert question(named) == question(Site(latitude=1.0, height=2.0))
    assert question(named) != question(Site(latitude=1.0, height=3.0))
    assert question(Site(latitude=1.0)) != question(Site(latitude=1.0, height=None))


def test_code_that_differs_has_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("STATION_TESTS_COMPUTE", raising=False)
    monkeypatch.setattr(computed_once, "digest", lambda modules: str(number).encode())
    folders = []
    for number in range(5):
        folders.append(folder_of("procedures.frames", "rotation"))
        assert folders[-1] is not None
        os.utime(folders[-1], (number, number))
    assert len(set(folders)) == 5
    assert folder_of("procedures.frames", "rotation") == folders[-1]
    assert len(list(folders[-1].parent.iterdir())) == computed_once.STATES_KEPT
    assert folder_of("procedures.frames", "wrapped").parent != folders[-1].parent
    monkeypatch.setenv("STATION_TESTS_COMPUTE", "1")
    assert folder_of("procedures.frames", "rotation") is None


def test_what_keeps_answers_is_no_code_behind_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A function more in `COMPUTED` would else make every answer of the tests' own functions unknown."""
    behind = list[Collection[str]]()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("STATION_TESTS_COMPUTE", raising=False)
    monkeypatch.setattr(computed_once, "digest", lambda modules: behind.append(modules) or b"")
    folder_of("tests.test_code_behind", "any")
    assert {"tests.test_code_behind", "tests.paths", "procedures.frames"} <= {*behind[0]}
    computed_once._code_of.__wrapped__(frozenset(["tests.test_code_behind"]))  # noqa: SLF001 - in a question
    assert behind[1] == behind[0]
    assert not computed_once.OF_KEEPING & {*behind[0]}


def test_code_that_loads_modules_by_names_in_a_table_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it returned was known after any change of a command, and its tests could not fail."""
    with pytest.raises(TypeError, match=r"station\.cli, which loads modules by names"):
        folder_of("tests.station.locate.test_imu_source", "located")
    loaded = re.compile(r"import_module\((?!module\)|\"cv2\")")  # but python-can's and a library that may lack
    files = [each for package in PACKAGES if package != "tests" for each in (ROOT / package).rglob("*.py")]
    found = [each.relative_to(ROOT).with_suffix("") for each in files if loaded.search(each.read_text())]
    tables = {".".join(each.parts) for each in found}
    assert "station.cli" in tables
    assert all(each.startswith(computed_once.BY_NAME) for each in tables), tables


def test_what_is_in_the_place_of_a_part_in_all_tests_is_no_change(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computed_once, "PARTS", Parts())
    monkeypatch.setattr(frames, "rotation", lambda vector: np.full((3, 3), 7.0))
    assert computed_once._changed(["procedures.frames"], [])  # noqa: SLF001
    computed_once.look_anew()
    assert not computed_once._changed(["procedures.frames"], [])  # noqa: SLF001


def test_arrays_that_differ_in_a_number_a_shape_or_their_order_are_other_questions(
    tmp_path: Path, asked: list[int]
) -> None:
    def summed(*arrays: np.ndarray) -> float:
        asked.append(len(arrays))
        return float(arrays[0].ravel(order="K")[0])

    once = kept(summed, tmp_path, lambda besides: False)
    table = np.arange(6.0).reshape(2, 3)
    other = table.copy()
    other[1, 2] = 7.0
    as_integers, by_column = table.astype(np.int64), np.asfortranarray(table)
    for each in (table, other, table.reshape(3, 2), as_integers, by_column, table[:, ::2]):
        once(each)
    once(table[0], table[1])  # the same bytes in two pieces
    once(table[0], table[1], table[:0])
    assert len(asked) == 8
    once(other.copy())
    assert len(asked) == 8
