"""A simulated wheel tells the speed of the moment at which each of its frames is due."""

from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from drivers.simulated import wheel_on_can
from drivers.simulated.wheel_on_can import RATE_HZ, SimulatedWheel, told_speeds


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


def test_a_wheel_tells_its_own_speed_with_noise_while_it_turns_and_nothing_while_it_stands() -> None:
    """10 s at rest, then 5 m/s: the wheel is 1 % smaller than it says; its noise is 0.02 m/s, never backwards."""
    t = np.arange(0.0, 400.0, 0.02)
    track: Any = SimpleNamespace(velocities=lambda t: np.where(t[:, None] < 200.0, 0.0, [3.0, 4.0, 0.0]))
    told = told_speeds(t, track, 1.01, np.random.default_rng(5))
    assert not told[t < 200.0].any()
    moving = told[t >= 200.0]
    assert moving.mean() == pytest.approx(5.0 / 1.01, abs=1e-3)
    assert moving.std() == pytest.approx(0.02, rel=0.05)
    slow: Any = SimpleNamespace(velocities=lambda t: np.full((len(t), 3), 1e-4))
    assert told_speeds(t, slow, 1.01, np.random.default_rng(5)).min() == 0.0
    assert told_speeds(t, None, 1.01, np.random.default_rng(5)).tolist() == [0.0] * len(t)
