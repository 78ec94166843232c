"""One instruction per phase of a step; who obeys each at once has done nothing in vain, however late that is."""

import json
from collections import deque
from collections.abc import Callable, Iterator
from itertools import groupby
from pathlib import Path

import numpy as np

from drivers.simulated.bench_control import BenchControl
from drivers.simulated.imu import COUNT_PER_G_S, COUNT_PER_RAD
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Step, as_repeats, dwell_steps, turn_steps
from station import cli
from station.guide.plain_screen import PlainScreen
from station.guide.simulated_operator import SimulatedOperator
from station.guide.stages.placement_stage import LEARNING
from station.guide.view import CalibrationView
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]
MOVE_S = 8.0


class RigHands(BenchControl):
    """The hands of a rig's device, without a line to them."""

    def __init__(self, rig: GuideRig) -> None:
        super().__init__("rig:1")
        self._rig, self.asked = rig, list[str]()

    def say(self, command: str) -> list[str]:
        """Do it at once."""
        self.asked.append(command)
        return self._rig.source.device.execute(command).split()[1:]


def phases(views: list[CalibrationView]) -> list[tuple[str, str]]:
    """Return what was asked for, step by step and change by change; a count of seconds or turns is no change."""

    def phase(view: CalibrationView) -> tuple[str, str]:
        step = view.live or view.wanted
        if view.stage == "turn" and view.turn is not None and view.turn.may_begin and not view.turn.is_back:
            return step, "turn"
        if view.stage == "turn" or (view.stage == "settle" and view.line != LEARNING):
            return step, "after" if view.turn is not None and view.turn.is_back else "hands off"
        return step, {"settle": "wait", "dwell": "measuring"}.get(view.stage, view.stage)

    return [key for key, _ in groupby(map(phase, views))]


def whole(rig: GuideRig, screen: PlainScreen | None = None) -> RigHands:
    """Have the simulated operator obey every instruction at once until all is done."""
    hands = RigHands(rig)
    operator = SimulatedOperator(hands, MOVE_S)

    def watch(view: CalibrationView) -> None:
        if screen:
            screen.show(view)
        operator.look(view)

    rig.run(rig.done(len(rig.context.checklist.steps)), watch, seconds=5000.0)
    return hands


def usual() -> list[Step]:
    """Return positions, the turns of two axes and the first position again."""
    first: list[Step] = dwells(1, 3, 5, 9, seconds=12.0)
    return list(as_repeats((*first, *turn_steps(1, 3.0)[:4], Dwell(1, 12.0))))


def test_each_step_of_a_whole_campaign_asks_for_each_thing_once(rig: Make) -> None:
    lines = list[str]()
    guided = rig(usual(), asks=False)
    hands = whole(guided, PlainScreen(lines.append, rings=False))
    dwell, turn = ["place", "hands off", "measuring"], ["place", "hands off", "turn", "after"]
    expected = [("dwell_01", what) for what in ("wait", "hands off", "measuring")]  # it stands there already
    expected += [(name, what) for name in ("dwell_03", "dwell_05", "dwell_09") for what in dwell]
    for axis in "xy":
        expected += [(f"turn_{axis}_plus", what) for what in turn]
        expected += [(f"turn_{axis}_minus", what) for what in turn[1:]]  # it begins where the cube stands
    expected += [("dwell_01_repeat", what) for what in dwell]
    assert phases(guided.seen)[: len(expected)] == expected
    assert not [text for text in guided.texts if text.startswith(("rejected", "still"))]
    placed = [words.split()[1] for words in hands.asked if words.startswith("place")]
    assert placed == ["3", "5", "9", "1", "5", "1"]
    assert len([words for words in hands.asked if words.startswith("turn")]) == 4
    reported = [line for line in lines if line.startswith("[")]
    assert len(reported) == len(set(reported))  # numbered by step: none comes twice in one


def test_a_guide_that_is_behind_the_device_sees_the_same_campaign(rig: Make) -> None:
    guided = rig(as_repeats((*dwells(1, 5, 9, seconds=8.0), *turn_steps(1, 3.0)[:2], Dwell(1, 8.0))), asks=False)
    hands, blocks = RigHands(guided), deque[object]()
    operator = SimulatedOperator(hands, MOVE_S)
    ready = guided.feed.ready

    def late() -> Iterator[object]:  # on a busy machine a device runs on before its seconds are looked at
        blocks.extend(ready())
        while len(blocks) > 7:
            yield blocks.popleft()

    guided.feed.ready = late  # type: ignore[assignment,method-assign]
    guided.run(guided.done(6), operator.look, seconds=3000.0)
    assert not [text for text in guided.texts if text.startswith(("rejected", "still"))]
    assert [words.split()[1] for words in hands.asked if words.startswith("place")] == ["5", "9", "1"]


def test_a_whole_campaign_of_a_unit_that_sends_rates_is_solved_to_the_truth(rig: Make, tmp_path: Path) -> None:
    guided = rig((*dwell_steps(5.0), *turn_steps(1, 5.0)), Truth.example(5), asks=False, format="kvh1750")
    whole(guided)
    assert cli.run(["solve", str(guided.folder), "--json", str(tmp_path / "s.json")]) == 0
    found = json.loads((tmp_path / "s.json").read_text())
    true = guided.source.device.truth
    for triad, k, unit in (
        ("accelerometer", true.accel_k / COUNT_PER_G_S, "output/g"),
        ("gyroscope", true.gyro_k / COUNT_PER_RAD, "output/(deg/s)"),
    ):
        scale = found[triad]["scale_factor"]
        assert scale["unit"] == unit
        assert np.all(np.abs(scale["value"] - k) < 5 * np.array(scale["std"])), triad
