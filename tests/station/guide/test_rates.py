"""A unit that sends rates is guided through a whole campaign, turns and all, and solved to its truth."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from drivers.simulated.imu import COUNT_PER_G_S, COUNT_PER_RAD
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Turn, dwell_steps, turn_steps
from station import cli
from station.guide.view import CalibrationView
from tests.station.guide.rig import GuideRig

STEPS = (*dwell_steps(5.0), *turn_steps(1, 5.0))
TRUTH = Truth.example(5)


class Hands:
    """Does what a guide asks for, once for each attempt at a step."""

    def __init__(self, rig: GuideRig) -> None:
        self._rig, self._done = rig, set[tuple[str, str, int]]()

    def __call__(self, view: CalibrationView) -> None:
        step = view.step(view.wanted)
        if step is None or view.stage not in {"place", "turn"}:
            return
        is_ready = view.stage == "place" or (view.turn is not None and view.turn.rest_s >= view.turn.rest_wanted_s)
        task = (view.stage, step.name, step.attempts)
        if is_ready and task not in self._done:
            self._done.add(task)
            turn = f"turn {step.axis} {step.direction} {step.revolutions} 2"
            self._rig.hands(turn if view.stage == "turn" else f"place {step.position or step.start_position} 5")


def test_a_whole_campaign_of_rates_is_solved_to_the_truth(rig: Callable[..., GuideRig], tmp_path: Path) -> None:
    guided = rig(STEPS, TRUTH, asks=False, format="kvh1750")
    guided.run(guided.done(len(STEPS)), Hands(guided))
    assert sum(isinstance(step, Turn) for step in STEPS) == 6
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
