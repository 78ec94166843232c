"""A line of one phase in four short recordings: its frequency, its size, of which sensors, and when it is none."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.samples.sample_blocks import SampleBlocks, sample_blocks
from procedures.samples.sample_lines import CoherentLine, coherent_line

PERIOD, N = 0.1, 512  # four blocks of 128 samples a recording
UNIT = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}
BEGINS = (0.0, 60.0, 131.0, 200.0)
HERTZ, SIZE = 1.7, 0.35
GYROS = [False] * 3 + [True] * 3


def times(begins: Sequence[float] = BEGINS) -> list[FloatArray]:
    return [np.asarray(begin + PERIOD * np.arange(1, N + 1)) for begin in begins]


def noise(seed: int, recordings: int = 4) -> FloatArray:
    """Return noise of six sensors, accelerometers first, of every recording."""
    return np.random.default_rng(seed).standard_normal((recordings, N, 6))


def wave(t: Sequence[FloatArray], hertz: float = HERTZ, phase: float = 0.0) -> FloatArray:
    return np.stack([np.cos(2 * np.pi * (hertz * each + phase)) for each in t])


def blocks_of(t: Sequence[FloatArray], values: FloatArray) -> SampleBlocks:
    soaks = [
        SoakRecord(f"{i}", 0, None, RateSeries(at, x[:, 3:], x[:, :3], np.full(len(at), 25.0), PERIOD))
        for i, (at, x) in enumerate(zip(t, values, strict=True))
    ]
    found = sample_blocks(soaks, UNIT)
    assert found is not None
    return found


def line(
    t: Sequence[FloatArray], values: FloatArray, is_usable: Sequence[bool] = (True,) * 6
) -> CoherentLine | None:
    return coherent_line(blocks_of(t, values), is_usable)


def planted(*sensors: int, seed: int = 1, size: float = SIZE, hertz: float = HERTZ) -> FloatArray:
    values = noise(seed)
    for sensor in sensors:
        values[:, :, sensor] += size * wave(times(), hertz)
    return values


@pytest.mark.parametrize(("sensor", "hertz"), [(0, 0.4), (4, 4.6)])
def test_a_line_of_one_sensor_is_reported_with_frequency_and_size(sensor: int, hertz: float) -> None:
    found = line(times(), planted(sensor, hertz=hertz))
    assert found is not None
    assert found.hertz == pytest.approx(hertz, abs=6e-4)  # a seventh of what 251 s resolve
    assert sensor in found.fitted
    assert {each // 3 for each in found.fitted} == {sensor // 3}
    fit = found.fitted[sensor]
    assert np.hypot(*fit.value) == pytest.approx(SIZE, abs=4 * np.sqrt(2 / (4 * N)))
    assert found.phase.period == pytest.approx(1 / hertz, rel=1e-3)
    assert [len(turns) for turns in found.phase.turns] == [N] * 4
    assert found.phase.turns[2] == pytest.approx(found.hertz * times()[2])
    assert found.phase.channel == "time"


def test_a_sensor_that_is_not_usable_has_no_line() -> None:
    values = planted(1, 4)
    found = line(times(), values, GYROS)
    assert found is not None
    assert 4 in found.fitted
    assert 1 not in found.fitted
    assert line(times(), planted(1), GYROS) is None
    assert line(times(), values, [False] * 6) is None


def test_two_recordings_are_enough_and_one_is_none() -> None:
    values = planted(4, size=0.6)
    two = line(times()[:2], values[:2])
    assert two is not None
    assert two.hertz == pytest.approx(HERTZ, abs=1e-3)
    whole = np.concatenate((values[:2, :, :], values[2:, :, :]), axis=0).reshape(1, 4 * N, 6)
    whole[0, :, 4] += 5 * np.cos(2 * np.pi * HERTZ * PERIOD * np.arange(4 * N))
    assert line([PERIOD * np.arange(1.0, 4 * N + 1)], whole) is None


@pytest.mark.parametrize("size", [0.8])
def test_a_line_whose_phase_is_another_in_every_recording_is_none(size: float) -> None:
    values = noise(3)
    for i, phase in enumerate((0.0, 0.3, 0.1, 0.35)):
        values[i, :, 4] += size * wave(times()[i : i + 1], phase=phase)[0]
    assert line(times(), values) is None


@pytest.mark.parametrize("seed", [0])
def test_noise_has_none(seed: int) -> None:
    assert line(times(), noise(10 + seed)) is None
