"""A unit without a serial number is known by its counts, as far as they tell it from another."""

from collections.abc import Callable

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell
from station.files.campaign_folder.plan_file import UnitRecord, read_note, write_note
from station.guide.stages.guide import Guide
from station.guide.stages.unit_recognition_stage import same_unit
from station.stream.connected_unit import UnitChanged
from station.stream.live.stillness import TICKS_PER_BLOCK
from tests.station.guide.rig import GuideRig, dwells

SECONDS = 20


def record(truth: Truth, position: int = 1, seed: int = 1) -> UnitRecord:
    """Return what a station sees of a unit at rest, switched on anew."""
    series = SimulatedBench(truth, seed).perform(Dwell(position, SECONDS))
    assert series.gyro is not None
    assert series.accel is not None
    counts = np.hstack((series.gyro, series.accel))
    ticks = counts.reshape(SECONDS, TICKS_PER_BLOCK, -1, 6).sum(axis=2)
    return UnitRecord(
        model="M",
        serial="as you answered",
        serial_from_wire=False,
        period=truth.sample_period_s,
        noise=tuple(ticks.var(axis=1, ddof=1).mean(axis=0).tolist()),
        rate=tuple((counts.sum(axis=0) / SECONDS).tolist()),
    )


def compared(before: UnitRecord, now: UnitRecord) -> tuple[bool, str]:
    return same_unit(before, np.array(now.rate), np.array(now.noise), now.period)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("position", [1, 2])
def test_a_unit_switched_off_and_on_is_known_again_in_either_heading(seed: int, position: int) -> None:
    before = record(Truth.example(seed))
    is_alike, why = compared(before, record(Truth.example(seed), position, seed=99 + seed))
    assert is_alike, why


def test_another_unit_of_the_model_is_hardly_ever_taken_for_it() -> None:
    units = [record(Truth.example(seed)) for seed in range(20)]
    answers = [compared(a, b)[0] for i, a in enumerate(units) for b in units[:i]]
    assert answers.count(True) < 0.01 * len(answers)
    is_alike, why = compared(units[0], units[1])
    assert not is_alike
    assert "different from the campaign's first dwell: " in why
    assert "accelerometer x by " in why


def test_what_cannot_be_compared_is_unsure_and_says_what_to_do() -> None:
    before = record(Truth.example(1))
    is_alike, why = compared(before, record(Truth.example(1), 3))
    assert not is_alike
    assert "it rests with IMU x down; put it down with IMU x up" in why
    for bare in ({"rate": None}, {"noise": None}):
        assert not compared(before.model_copy(update=bare), before)[0]
    is_alike, why = compared(before, before.model_copy(update={"period": 0.01}))
    assert not is_alike
    assert why.startswith("it sends every 0.01 s")


Make = Callable[..., GuideRig]


def begun(rig: Make) -> GuideRig:
    """Return a campaign with one dwell, which keeps how the unit looked in it."""
    guided = rig(dwells(1, 2))
    unit = UnitRecord(model="FOG", serial="7", serial_from_wire=False, period=guided.feed.period)
    write_note(guided.folder, unit)
    guided.run(guided.done(1))
    return guided


def gone_on(guided: GuideRig) -> None:
    record = read_note(guided.folder, UnitRecord)
    assert record is not None
    assert record.rate is not None
    guided.guide = Guide(guided.context, warms_up=False, unsure=record)


def test_the_same_unit_looks_the_same_and_is_still_asked_for(rig: Make) -> None:
    guided = begun(rig)
    gone_on(guided)
    view = guided.run(lambda v: v.question is not None)
    assert "its rates and noise match the first dwell" in view.question.text
    guided.rest(30)
    assert guided.view.done == 1  # nothing is recorded before the answer
    guided.execute("answer", key="y")
    guided.hands("place 2 8")
    guided.run(guided.done(2))


def test_another_unit_is_distinguished_and_no_ends_it(rig: Make) -> None:
    guided = begun(rig)
    record = read_note(guided.folder, UnitRecord)
    assert record is not None
    assert record.rate is not None
    rate = [value * 1.02 if i == 3 else value for i, value in enumerate(record.rate)]
    guided.guide = Guide(guided.context, warms_up=False, unsure=record.model_copy(update={"rate": tuple(rate)}))
    view = guided.run(lambda v: v.question is not None)
    assert "different from the campaign's first dwell: accelerometer x by" in view.question.text
    with pytest.raises(UnitChanged):
        guided.execute("answer", key="n")
