"""A map that was killed goes on where it was; who does the work changes no number."""

import json
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import psutil
import pytest

from station import cli
from station.results.resolve import dask_engine
from station.results.resolve.parallel_map import Engine, OneProcess, map_restartable, open_engine
from tests.paths import ROOT
from tests.patience import HANG_S
from tests.refusals import refused
from tests.station.results.resolve.jobs import die, draw, draw_if_even


@pytest.fixture(scope="module", autouse=True)
def _workers_import_tests() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:  # a worker starts with the sys.path of whoever starts it
        patch.syspath_prepend(ROOT)
        for wait in ("SCHEDULER_TIMEOUT_S", "NO_WORKER_TIMEOUT_S"):  # a worker's imports on a busy machine
            patch.setattr(dask_engine, wait, HANG_S)
        yield


@pytest.fixture(scope="module")
def two(_workers_import_tests: None) -> Iterator[Engine]:
    with open_engine(2) as engine:
        yield engine


def values(engine: Engine, folder: Path | None = None) -> dict[int, list[float]]:
    found = map_restartable(draw, range(40), lambda seed: seed, folder, engine)
    return {one.item: one.answer.result["values"] for one in found if one.answer.result}


def test_a_run_that_was_ended_goes_on_and_ends_with_the_same_numbers(tmp_path: Path) -> None:
    begun = map_restartable(draw, range(40), lambda seed: seed, tmp_path, OneProcess())
    assert len(list(islice(begun, 13))) == 13
    begun.close()
    second = list(map_restartable(draw, range(40), lambda seed: seed, tmp_path, OneProcess()))
    assert sum(one.was_kept for one in second) == 13
    assert {one.item: one.answer.result["values"] for one in second if one.answer.result} == values(OneProcess())


def test_two_workers_give_the_numbers_of_one_to_the_last_bit(two: Engine, tmp_path: Path) -> None:
    assert two.workers == 2
    assert values(two, tmp_path) == values(OneProcess()) == values(OneProcess(), tmp_path)


def test_workers_of_this_machine_listen_on_the_loopback_alone(two: Engine) -> None:
    us = psutil.Process()
    heard = {
        each.laddr.ip
        for process in (us, *us.children(recursive=True))
        for each in process.net_connections(kind="inet")
        if each.status == psutil.CONN_LISTEN
    }
    assert heard == {"127.0.0.1"}


@pytest.mark.parametrize("damage", ["cut", "changed", "of another key"])
def test_a_kept_result_that_is_not_what_was_written_is_computed_again(tmp_path: Path, damage: str) -> None:
    whole = values(OneProcess(), tmp_path)
    first, second = sorted(tmp_path.iterdir())[:2]
    match damage:
        case "cut":
            first.write_bytes(first.read_bytes()[:-9])
        case "changed":
            document = json.loads(first.read_text())
            document["result"]["values"][0] += 1e-9
            first.write_text(json.dumps(document))
        case _:
            first.write_bytes(second.read_bytes())
    again = list(map_restartable(draw, range(40), lambda seed: seed, tmp_path, OneProcess()))
    assert sum(not one.was_kept for one in again) == 1
    assert {one.item: one.answer.result["values"] for one in again if one.answer.result} == whole


def test_a_worker_with_other_code_refuses(two: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("station.results.resolve.dask_engine.code_hash", lambda _: "f" * 64)
    elsewhere = dask_engine.DaskEngine(two.client, is_local=False)  # type: ignore[union-attr]
    ((_, answer),) = elsewhere.run(draw, [1])
    assert answer.fault is not None
    assert "expected ffffffffffff; install the same station" in answer.fault.text


def test_one_bad_item_stops_no_other_and_is_tried_again(two: Engine, tmp_path: Path) -> None:
    for _ in range(2):
        found = list(map_restartable(draw_if_even, range(6), lambda seed: seed, tmp_path, two))
        faults = {one.item: one.answer.fault for one in found if one.answer.fault}
        assert sorted(faults) == [1, 3, 5]
        assert "found 3, expected an even seed" in faults[3].text
    assert sum(one.was_kept for one in found) == 3


def test_a_killed_worker_is_survived_and_what_kills_every_worker_is_named(tmp_path: Path) -> None:
    once, always = tmp_path / "once", tmp_path / "always"
    once.mkdir()
    always.mkdir()
    with open_engine(2) as engine:
        survived = dict(engine.run(die, [(str(once), 1)]))
        answers = dict(engine.run(die, [(str(always), 99)]))  # by itself: it may take others' workers with it
        assert survived[0].result == {"deaths": 1}
        fault = answers[0].fault
        assert fault is not None
        assert "KilledWorker" in fault.text
        assert len(values(engine)) == 40


def test_an_address_where_nobody_answers_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(dask_engine, "SCHEDULER_TIMEOUT_S", 0.5)
    for address in ("tcp://127.0.0.1:1", "tcp://127.0.0.1:x", "nonsense://a"):
        command = ["resolve", str(tmp_path), "--scheduler", address, "--db", str(tmp_path / "s.db")]
        assert cli.run(command) == 2
        reported = capsys.readouterr().err
        assert f"found no answer at {address}" in reported
        assert "expected a Dask scheduler; check --scheduler" in reported


def test_without_the_extra_more_than_one_worker_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("station.results.resolve.parallel_map.find_spec", lambda name: None)
    with open_engine() as engine:
        assert engine.workers == 1
    with refused(ConnectionError, None, "make extra-cluster"), open_engine(2):
        pass
