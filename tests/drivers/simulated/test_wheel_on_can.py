"""A simulated wheel tells the speed of the moment at which each of its frames is due."""

from threading import Event
from types import SimpleNamespace
from typing import Any

import pytest

from drivers.simulated import wheel_on_can
from drivers.simulated.wheel_on_can import RATE_HZ, SimulatedWheel


def test_each_frame_tells_the_speed_of_its_own_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wheel_on_can, "told_speeds", lambda t, *_: t)  # as fast as it is late
    sent = list[bytes]()
    wheel: Any = SimpleNamespace(
        _sent=0, _stop=Event(), _track=None, _scale=1.0, _rng=None,
        _signal=SimpleNamespace(frame=lambda speed, host_ns: f"{speed:.3f} ".encode()),
        _line=SimpleNamespace(write=lambda data, stop: sent.append(data)),
    )  # fmt: skip
    wheel._stop.set()  # noqa: SLF001 - it would wait for the next frame else
    for now, is_plugged in ((0.2, True), (0.4, True), (0.4, True), (0.6, False), (0.8, True)):
        SimulatedWheel._step(wheel, now, is_plugged=is_plugged)  # noqa: SLF001
    told = [float(each) for each in b"".join(sent).split()]
    first, last = round(0.4 * RATE_HZ), round(0.6 * RATE_HZ)
    expected = [i / RATE_HZ for i in [*range(first), *range(last, round(0.8 * RATE_HZ))]]
    assert told == pytest.approx(expected, abs=1e-3)  # what was due while nobody was there is not made up for
