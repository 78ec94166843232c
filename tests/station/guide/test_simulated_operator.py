"""Simulated hands do what is asked once, again where it is long overdue, and are called again if lost."""

from contextlib import closing
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drivers.errors import BadDeviceUrl, ControlRefused, ControlUnreachable
from drivers.ports import open_port
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.device import MAX_CHUNK_SAMPLES
from drivers.simulated.server import MAX_AHEAD_S, SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from station.cli import app
from station.errors import exit_code
from station.guide.simulated_operator import REPEAT_AFTER_S, RETRY_S, HandsLost, SimulatedOperator
from station.guide.view import CalibrationView, StepView

MOVE_S = 5.0
WANTS_7 = CalibrationView(
    stage="place", wanted="dwell_07", steps=(StepView(name="dwell_07", state="todo", position=7),)
)


def test_what_was_asked_for_is_done_again_only_when_it_is_long_overdue() -> None:
    with (
        SimulatedDevice(Truth.example(1), 1, speed=0.0) as device,
        closing(SimulatedOperator(BenchControl(device.control), MOVE_S)) as operator,
        BenchControl(device.control) as hands,
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


class StubHands(BenchControl):
    """Hands that answer while ``is_there``, at device time ``now``; ``refusal`` is what they answer instead."""

    def __init__(self) -> None:
        super().__init__("127.0.0.1:1")
        self.now, self.is_there, self.refusal, self.asked, self.calls = 50.0, True, "", list[str](), 0

    def say(self, command: str) -> list[str]:
        self.calls += 1
        if not self.is_there:
            raise ControlUnreachable(self.address, command, "Connection refused")
        if self.refusal:
            raise ControlRefused(self.address, command, self.refusal)
        if command == "time":
            return [str(self.now)]
        self.asked.append(command)
        return ["time", str(self.now), "done", str(self.now + 5.0)]


class Clock:
    now = 1000.0

    def __call__(self) -> float:
        return self.now


def seen(at: float, **more: object) -> CalibrationView:
    return WANTS_7.model_copy(update={"time_s": at, **more})


def test_hands_that_do_not_answer_are_called_again_and_go_on() -> None:
    hands, clock = StubHands(), Clock()
    operator = SimulatedOperator(hands, 5.0, clock=clock)
    hands.is_there = False
    operator.look(seen(50.0))
    assert "Connection refused" in operator.lost
    calls = hands.calls
    operator.look(seen(50.1))
    assert hands.calls == calls  # not once more within the second
    clock.now += 40.0
    operator.look(seen(90.0))
    assert operator.lost_s == 40.0
    hands.is_there, hands.now = True, 95.0
    clock.now += RETRY_S
    operator.look(seen(95.0))
    assert not operator.lost
    operator.look(seen(95.1))
    assert [words.split()[:2] for words in hands.asked if "seen" not in words] == [["place", "7"]]


def test_hands_that_refuse_are_no_hands_to_wait_for() -> None:
    hands = StubHands()
    hands.refusal = "error position 99"
    with pytest.raises(HandsLost) as lost:
        SimulatedOperator(hands, 5.0).look(seen(50.0))
    assert exit_code(lost.value) == 4


@pytest.mark.parametrize("screen", ["--headless", "--plain"])
@pytest.mark.parametrize(
    "wrong",
    [("--hands", "9.79"), ("--device", "9.79"), ("--gnss", "tcp://h:1"), ("--device", "camera:/dev/video0")],
)
def test_a_campaign_does_not_begin_with_a_bad_address(tmp_path: Path, wrong: tuple[str, str], screen: str) -> None:
    out, db = str(tmp_path / "campaign"), str(tmp_path / "station.db")
    given = ["--device", "/dev/ttyUSB0", "--latitude", "48.1", "--out", out, "--db", db, screen, *wrong]
    result = CliRunner().invoke(app, ["calibrate", *given])
    assert isinstance(result.exception, BadDeviceUrl)
    assert (result.exception.code, exit_code(result.exception)) == (ErrorCode.DEVICE_ADDRESS, 2)
    assert not list(tmp_path.iterdir())


def test_a_device_faster_than_time_waits_for_a_guide_that_falls_behind() -> None:
    with (
        SimulatedDevice(Truth.example(1), 1, speed=3000.0) as device,
        BenchControl(device.control) as hands,
        closing(open_port(device.url, 0.1)) as port,
    ):
        for seen in (0.0, 400.0):
            empty = 0  # reads
            while empty < 5 or hands.time() < seen + MAX_AHEAD_S:  # then it waits
                hands.seen(seen)  # a guide that says no more is waited for only some seconds
                empty = 0 if port.read(65536) else empty + 1
            one_chunk = MAX_CHUNK_SAMPLES * device.truth.sample_period_s
            assert hands.time() <= seen + MAX_AHEAD_S + 2 * one_chunk
