"""What acts sample by sample, in recordings short enough for their calls to be recorded: some thousand numbers."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord, TurnRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.sample_effects import sample_effects
from procedures.diagnosis.sample_turns import periodic_in_turns
from tests.stored.held import assert_held

N, PERIOD = 3072, 0.01  # samples, s
T = PERIOD * np.arange(1, N + 1)
SCALES = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}
SITE = Site(0.8, 9.8, 0.02)


@dataclass(frozen=True)
class Soak:
    """The rates of a triad (N, 3), and the channels (N,) beside them."""

    rate: FloatArray
    triad: str = "gyroscope"
    channels: dict[str, FloatArray] = field(default_factory=dict)

    def record(self, name: str = "soak") -> SoakRecord:
        """Return a recording whose numbers have two digits behind the point."""
        rate = {"gyroscope": None, "accelerometer": None, self.triad: np.round(self.rate, 2)}
        extra = {f"aux_{channel}": np.round(values, 2) for channel, values in self.channels.items()}
        series = RateSeries(
            np.round(T, 2), rate["gyroscope"], rate["accelerometer"], np.full(N, 25.0), PERIOD, extra=extra
        )
        return SoakRecord(name, 0, None, series)


def white(seed: int) -> FloatArray:
    return np.random.default_rng(seed).normal(size=(N, 3))


def in_a_ramp() -> Soak:
    """Gyroscope z has two harmonics of a channel that wraps."""
    rng, rate = np.random.default_rng(1), white(2)
    turns = (3.7 * T + 1e-3 * np.cumsum(rng.normal(size=N))) % 1.0
    rate[:, 2] += 0.8 * np.cos(2 * np.pi * turns) + 0.6 * np.sin(4 * np.pi * turns)
    return Soak(rate, channels={"ramp": 360 * turns})


def in_an_angle() -> Soak:
    """Gyroscope x has the sixth of an angle that never wraps."""
    angle, rate = np.cumsum(2.0 + 0.5 * np.random.default_rng(3).normal(size=N)), white(4)
    rate[:, 0] += 0.8 * np.cos(np.radians(6 * angle))
    return Soak(rate, channels={"motor": angle})


def behind_a_current() -> Soak:
    """Accelerometer y follows a current three samples late."""
    current, rate = np.repeat(np.random.default_rng(5).normal(size=N // 4), 4), white(6)
    rate[3:, 1] += 0.5 * current[:-3]
    return Soak(rate, "accelerometer", {"current": current})


def with_a_line() -> Soak:
    """Gyroscope y has a line that keeps its phase, where x has one that does not."""
    rate, phase = white(7), np.cumsum(0.05 * np.random.default_rng(8).normal(size=N))
    rate[:, 1] += 0.9 * np.sin(2 * np.pi * 7.3 * T)
    rate[:, 0] += 1.2 * np.sin(2 * np.pi * 20 * T + phase)
    return Soak(rate)


SOAKS = {each.__name__: each for each in (in_a_ramp, in_an_angle, behind_a_current, with_a_line)}


@pytest.mark.parametrize("name", SOAKS)
def test_a_short_soak(name: str) -> None:
    record = SOAKS[name]().record()
    found = sample_effects([Campaign("m", "s", False, SITE, (), (), soaks=(record,))], SCALES)
    assert_held("small_samples", name, found)


def test_two_soaks_with_the_same_channel() -> None:
    first, other = in_a_ramp(), in_a_ramp()
    second = Soak(other.rate[::-1], channels={name: values[::-1] for name, values in other.channels.items()})
    soaks = first.record("first"), second.record("second")
    found = sample_effects([Campaign("m", "s", False, SITE, (), (), soaks=soaks)], SCALES)
    assert_held("small_samples", "two soaks", found)


def turn(seed: int, axis: str, way: int, gear: float, planted: dict[int, tuple[int, float]]) -> TurnRecord:
    """Two revolutions by hand with a motor's angle at ``gear``; ``planted`` (harmonic, deg/s) by sensor."""
    rng, n, period = np.random.default_rng(seed), 260, 0.05
    t = period * np.arange(1, n + 1)
    speed = np.clip(np.minimum(t - 1, t[-1] - 1 - t), 0, 2) * (1 + 0.1 * np.sin(2 * np.pi * 0.3 * t))
    rate = way * 720 * speed / (speed.sum() * period)
    angle = np.cumsum(rate) * period
    motor = np.round((130 * t + 3 * np.sin(t) if gear == 0 else gear * angle + 77) % 360, 3)
    gyro, up = 0.02 * rng.normal(size=(n, 3)), "xyz".index(axis)
    gyro[:, up] += rate
    gyro[:, (up + 1) % 3] += 0.004 * np.cos(np.radians(angle)) + 1e-3 * rate
    for sensor, (harmonic, size) in planted.items():
        gyro[:, sensor] += size * np.sin(np.radians(harmonic * motor))
    series = RateSeries(
        np.round(t, 2), np.round(gyro, 3), None, np.full(n, 25.0), period, extra={"aux_motor": motor}
    )
    return TurnRecord(f"{axis}{way}", axis, "+" if way > 0 else "-", 2, {"x": 1, "y": 5, "z": 9}[axis], series)


TURNS: dict[str, dict[str, Any]] = {
    "an angle that turns along": {"gear": 1.0, "planted": {0: (2, 0.5), 2: (2, 0.4)}},
    "a geared one": {"gear": 7.0, "planted": {1: (1, 0.1)}},
    "a motor of its own": {"gear": 0.0, "planted": {0: (1, 0.5), 1: (1, 0.4)}},
    "nothing": {"gear": 1.0, "planted": {}},
}


@pytest.mark.parametrize("name", TURNS)
def test_short_turns(name: str) -> None:
    turns = tuple(
        turn(10 * i, axis, way, **TURNS[name]) for i, (axis, way) in enumerate((("x", 1), ("y", -1), ("z", 1)))
    )
    found = periodic_in_turns([Campaign("m", "s", False, SITE, (), turns)], SCALES)
    assert_held("small_samples", name, found)
    assert bool(found[0]) == (name != "nothing")
