"""The simulated hands do what is asked once, and again where it was undone and is asked for long after."""

import time
from contextlib import closing

from drivers.ports import open_port
from drivers.simulated.server import MAX_AHEAD_S, SimulatedDevice
from drivers.simulated.simulated_hands import SimulatedHands
from drivers.simulated.truth import Truth
from station.guide.simulated_operator import REPEAT_AFTER_S, SimulatedOperator
from station.guide.view import CalibrationView, StepView, TurnView

MOVE_S = 5.0
WANTS_7 = CalibrationView(
    stage="place", wanted="dwell_07", steps=(StepView(name="dwell_07", state="todo", position=7),)
)


def test_what_was_asked_for_is_done_again_only_when_it_is_long_overdue() -> None:
    with (
        SimulatedDevice(Truth.example(1), 1, speed=0.0) as device,
        closing(SimulatedOperator(SimulatedHands(device.control), MOVE_S)) as operator,
        SimulatedHands(device.control) as hands,
        closing(open_port(device.url, 0.1)) as port,
    ):

        def wait_until(time: float) -> None:
            while hands.time() <= time:
                port.read(65536)

        operator.look(WANTS_7)
        over = hands.done()
        wait_until(over + REPEAT_AFTER_S / 2)
        operator.look(WANTS_7)
        assert hands.done() <= hands.time()
        wait_until(over + REPEAT_AFTER_S)
        operator.look(WANTS_7)
        assert hands.done() > over + REPEAT_AFTER_S


def test_the_turn_under_way_is_done_though_something_else_is_to_come_next() -> None:
    turn = StepView(name="turn_x_plus", state="live", axis="x", direction="+", revolutions=1, start_position=1)
    is_ready = TurnView(
        revolutions=0.0, wanted=1, speed_deg_s=0.0, slow_deg_s=5.0, fast_deg_s=100.0, rest_s=5.0,
        rest_wanted_s=5.0, may_begin=True,
    )  # fmt: skip
    steps = (WANTS_7.steps[0].model_copy(update={"state": "redo"}), turn)
    view = CalibrationView(stage="turn", wanted="dwell_07", live="turn_x_plus", steps=steps, turn=is_ready)
    with (
        SimulatedDevice(Truth.example(1), 1, speed=0.0) as device,
        closing(SimulatedOperator(SimulatedHands(device.control), MOVE_S)) as operator,
        SimulatedHands(device.control) as hands,
    ):
        hands.place(1, 0.0)
        operator.look(view)
        assert hands.done() > hands.time()


def test_a_device_faster_than_time_waits_for_a_guide_that_falls_behind() -> None:
    with (
        SimulatedDevice(Truth.example(1), 1, speed=3000.0) as device,
        SimulatedHands(device.control) as hands,
        closing(open_port(device.url, 0.1)) as port,
    ):
        for seen in (0.0, 400.0):
            hands.seen(seen)
            wait_for = time.monotonic() + 1.0
            while time.monotonic() < wait_for:
                port.read(65536)
            assert seen + MAX_AHEAD_S - 1.0 < hands.time() < seen + MAX_AHEAD_S + 200.0  # and the chunk under way
