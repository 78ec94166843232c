from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from procedures.campaign.plan_steps import Dwell, Plan, Step, Turn, run
from procedures.counts.sample_records import CountSeries, Series


def answer(position: int) -> Series:
    return CountSeries(np.array([float(position)]), None, None, np.zeros(1), 0.02)


class Echo:
    """Answers a dwell with its position as time; fails where it is told to."""

    def __init__(self, fails_at: int | None = None) -> None:
        self.done: list[Step] = []
        self._fails_at = fails_at

    def perform(self, step: Step) -> Series:
        assert isinstance(step, Dwell)
        if step.position == self._fails_at:
            raise OSError("unplugged")
        self.done.append(step)
        return answer(step.position)


def three() -> Plan[list[float]]:
    times = []
    for position in (3, 1, 2):
        series = yield Dwell(position, 1.0)
        times.append(float(series.t[0]))
    return times


def retrying(caught: list[str]) -> Plan[float]:
    try:
        yield Dwell(1, 1.0)
    except OSError as error:
        caught.append(str(error))
    series = yield Dwell(2, 1.0)
    return float(series.t[0])


def nothing() -> Plan[str]:
    return "done"
    yield Dwell(1, 1.0)  # makes it a generator


def test_answers_reach_the_plan_in_the_order_of_its_steps() -> None:
    bench = Echo()
    assert run(three(), bench) == [3.0, 1.0, 2.0]
    assert bench.done == [Dwell(3, 1.0), Dwell(1, 1.0), Dwell(2, 1.0)]


def test_what_the_bench_raises_is_raised_in_the_plan_at_its_step() -> None:
    caught: list[str] = []
    assert run(retrying(caught), Echo(fails_at=1)) == 2.0
    assert caught == ["unplugged"]


def test_what_the_plan_does_not_catch_ends_it() -> None:
    bench = Echo(fails_at=1)
    with pytest.raises(OSError, match="unplugged"):
        run(three(), bench)
    assert bench.done == [Dwell(3, 1.0)]


def test_a_plan_of_no_steps_returns_its_result() -> None:
    assert run(nothing(), Echo()) == "done"


def test_steps_are_frozen_and_name_their_files() -> None:
    step = Dwell(3, 100.0)
    with pytest.raises(FrozenInstanceError):
        step.position = 4  # type: ignore[misc]
    assert step.name == "dwell_03"
    assert Turn("x", "+", 3, 1, 5.0).name == "turn_x_plus"
    assert Turn("z", "-", 3, 9, 5.0).name == "turn_z_minus"
