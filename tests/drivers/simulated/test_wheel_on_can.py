"""A simulated wheel tells the speed of the moment at which each of its frames is due."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from drivers.can.wheel_signal import WheelDecoder, wheel_signal
from drivers.ports import open_port
from drivers.simulated.companions.wheel_on_can import DBC, SIGNAL, SimulatedWheel, wheel_speeds, wheel_toml
from station.stream.wheel import read_description
from tests.patience import until


def test_a_wheel_gives_its_own_speed_with_noise_while_it_turns_and_nothing_while_it_stands() -> None:
    """10 s at rest, then 5 m/s: the wheel is 1 % smaller than it says; its noise is 0.02 m/s, never backwards."""
    t = np.arange(0.0, 400.0, 0.02)
    track: Any = SimpleNamespace(velocities=lambda t: np.where(t[:, None] < 200.0, 0.0, [3.0, 4.0, 0.0]))
    reported = wheel_speeds(t, track, 1.01, np.random.default_rng(5))
    assert not reported[t < 200.0].any()
    moving = reported[t >= 200.0]
    assert moving.mean() == pytest.approx(5.0 / 1.01, abs=1e-3)
    assert moving.std() == pytest.approx(0.02, rel=0.05)
    slow: Any = SimpleNamespace(velocities=lambda t: np.full((len(t), 3), 1e-4))
    assert wheel_speeds(t, slow, 1.01, np.random.default_rng(5)).min() == 0.0
    assert wheel_speeds(t, None, 1.01, np.random.default_rng(5)).tolist() == [0.0] * len(t)


def test_its_file_is_read_as_the_wheel_that_it_is(tmp_path: Path) -> None:
    (tmp_path / "axle.toml").write_text(wheel_toml("can://slcan/dev/x?bitrate=500000", DBC, "[0.0, -1.0, 0.0]"))
    described = read_description(tmp_path / "axle.toml")
    assert list(described.table.forward) == [0.0, -1.0, 0.0]
    assert described.table.wheel_std_m_s == 0.03
    (tmp_path / "axle.toml").write_text(wheel_toml("can://slcan/dev/x?bitrate=500000", DBC))
    assert read_description(tmp_path / "axle.toml").table.forward == [1.0, 0.0, 0.0]


def test_its_frames_come_by_its_address_at_the_speed_it_has(tmp_path: Path) -> None:
    with SimulatedWheel(None, speed=20.0, link=tmp_path / "bus") as wheel:
        assert wheel.url == f"can://slcan{tmp_path / 'bus'}?bitrate=500000"
        port, decoder, reported = open_port(wheel.url), WheelDecoder(wheel_signal(DBC, SIGNAL)), list[float]()

        def read() -> None:
            reported.extend(each.speed for each in decoder.feed(port.read(4096), 0))

        until(lambda: len(reported) >= 50, read)
        port.close()
    assert reported[:50] == [0.0] * 50
    assert (decoder.refused, decoder.bad) == (0, 0)
