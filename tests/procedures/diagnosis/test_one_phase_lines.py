"""A line of one phase in four short recordings: its frequency, its size, of which sensors, and when it is none."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis import coherent_lines
from procedures.diagnosis.coherent_lines import CoherentLine, coherent_line
from procedures.diagnosis.sample_blocks import SampleBlocks, sample_blocks

PERIOD, N = 0.1, 512  # four blocks of 128 samples a recording
UNIT = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}
BEGINS = (0.0, 60.0, 131.0, 200.0)
HERTZ, SIZE = 1.7, 0.35
ON_GRID = 870 / 512  # Hz, of the 512 s that are transformed
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


@pytest.mark.parametrize("hertz", [0.4, 1.7, 4.6])
@pytest.mark.parametrize("sensor", [0, 4])
def test_a_line_of_one_sensor_is_told_with_frequency_and_size(sensor: int, hertz: float) -> None:
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


def test_a_line_of_a_whole_triad_is_fitted_to_each_of_its_sensors() -> None:
    found = line(times(), planted(3, 4, 5, size=0.3))
    assert found is not None
    assert set(found.fitted) == {3, 4, 5}
    assert len({fit.log_p for fit in found.fitted.values()}) == 1


def test_lines_of_both_triads_are_told_of_the_likelier() -> None:
    values = planted(0, 1, 2, size=0.25) + SIZE * np.eye(6)[3] * wave(times(), 0.9)[:, :, None]
    found = line(times(), values)
    assert found is not None
    assert set(found.fitted) == {0, 1, 2}
    assert found.hertz == pytest.approx(HERTZ, abs=1e-3)


def log_p_of(values: FloatArray, t: Sequence[FloatArray], hertz: float) -> float:
    """Return ln p of the power over unit noise, of which 90 near frequencies tell, of 1884 and 8 ways tried."""
    power = abs(np.sum(values * np.exp(-2j * np.pi * hertz * np.stack(t)))) ** 2 / values.size
    return float(np.log(8 * 1.5 * 2512 / 2) - 90 * np.log1p(power / 90))


@pytest.mark.parametrize("sensor", [1, 3])
def test_its_p_is_that_of_a_power_over_noise_with_all_frequencies_counted(sensor: int) -> None:
    values = planted(sensor, hertz=ON_GRID)
    found = line(times(), values)
    assert found is not None
    assert found.fitted[sensor].log_p == pytest.approx(log_p_of(values[:, :, sensor], times(), ON_GRID), rel=0.1)


def test_a_sensor_that_is_not_usable_has_no_line() -> None:
    values = planted(1, 4)
    found = line(times(), values, GYROS)
    assert found is not None
    assert 4 in found.fitted
    assert 1 not in found.fitted
    assert line(times(), planted(1), GYROS) is None
    assert line(times(), values, [False] * 6) is None


def test_a_single_usable_sensor_of_a_triad_is_enough() -> None:
    found = line(times(), planted(4), [False] * 4 + [True, False])
    assert found is not None
    assert set(found.fitted) == {4}


def test_two_recordings_are_enough_and_one_is_none() -> None:
    values = planted(4, size=0.6)
    two = line(times()[:2], values[:2])
    assert two is not None
    assert two.hertz == pytest.approx(HERTZ, abs=1e-3)
    whole = np.concatenate((values[:2, :, :], values[2:, :, :]), axis=0).reshape(1, 4 * N, 6)
    whole[0, :, 4] += 5 * np.cos(2 * np.pi * HERTZ * PERIOD * np.arange(4 * N))
    assert line([PERIOD * np.arange(1.0, 4 * N + 1)], whole) is None


@pytest.mark.parametrize("order", [(3, 1, 0, 2), (1, 0, 3, 2)])
def test_recordings_need_not_stand_in_the_order_of_their_times(order: tuple[int, ...]) -> None:
    values, t = planted(4), times()
    plain = line(t, values)
    found = line([t[i] for i in order], values[list(order)])
    assert plain is not None
    assert found is not None
    assert found.hertz == pytest.approx(plain.hertz, abs=1e-7)
    assert found.fitted[4].log_p == pytest.approx(plain.fitted[4].log_p)


@pytest.mark.parametrize(("begin", "is_one_clock"), [(51.2, True), (51.1, False), (30.0, False)])
def test_recordings_that_overlap_have_no_clock_in_common(begin: float, is_one_clock: bool) -> None:
    t = times((0.0, begin, 131.0, 200.0))
    values = noise(1)
    values[:, :, 4] += 0.5 * wave(t)
    assert (line(t, values) is not None) == is_one_clock


@pytest.mark.parametrize(("samples", "is_found"), [(2512, True), (2511, False)])
def test_a_campaign_that_is_too_long_is_not_transformed(
    monkeypatch: pytest.MonkeyPatch, samples: int, is_found: bool
) -> None:
    monkeypatch.setattr(coherent_lines, "MAX_SPAN", samples)
    assert (line(times(), planted(4)) is not None) == is_found


@pytest.mark.parametrize("off", [0.03, 0.05, 0.0875])
def test_recordings_may_stand_between_the_samples_of_the_first(off: float) -> None:
    """At 4.6 Hz half a sample is nearly half a turn: laid on whole samples the line would go."""
    t = times((0.0, 60.0 + off, 131.0 - off, 200.0 + off))
    values = noise(2)
    hertz = ON_GRID + 1472 / 512
    values[:, :, 4] += SIZE * wave(t, hertz)
    found = line(t, values)
    assert found is not None
    assert found.hertz == pytest.approx(hertz, abs=6e-4)
    assert found.fitted[4].log_p == pytest.approx(log_p_of(values[:, :, 4], t, hertz), rel=0.15)


@pytest.mark.parametrize(("hertz", "is_found"), [(0.15, False), (0.36, True)])
def test_what_is_slower_than_sixteen_periods_of_a_recording_is_no_line(hertz: float, is_found: bool) -> None:
    found = line(times(), planted(4, size=0.6, hertz=hertz))
    assert (found is not None and abs(found.hertz - hertz) < 2e-3) == is_found


@pytest.mark.parametrize("size", [0.8, 3.0])
def test_a_line_whose_phase_is_another_in_every_recording_is_none(size: float) -> None:
    values = noise(3)
    for i, phase in enumerate((0.0, 0.3, 0.1, 0.35)):
        values[i, :, 4] += size * wave(times()[i : i + 1], phase=phase)[0]
    assert line(times(), values) is None


@pytest.mark.parametrize("seed", range(4))
def test_noise_has_none(seed: int) -> None:
    assert line(times(), noise(10 + seed)) is None


def test_what_one_block_alone_does_is_none() -> None:
    values = noise(4)
    values[1, :128, 4] += 6 * wave(times())[1, :128]
    assert line(times(), values) is None


@pytest.mark.parametrize("hertz", [ON_GRID + 0.5 / 512, ON_GRID + 0.25 / 512, ON_GRID - 0.4 / 512])
def test_between_the_frequencies_of_the_transform_the_power_s_largest_is_found(hertz: float) -> None:
    """Of a line without noise but that of the others, to a hundredth of what 251 s resolve."""
    values = 0.01 * noise(5)
    values[:, :, 4] += wave(times(), hertz)
    found = line(times(), values)
    assert found is not None
    assert found.hertz == pytest.approx(hertz, abs=4e-5)


@pytest.mark.parametrize("slope", [0.5, -0.5])
def test_noise_that_is_larger_at_other_frequencies_does_not_hide_a_line(slope: float) -> None:
    """A line stands out of the noise about it: of a walk's, that falls by far, it is as far above its own."""
    values = noise(6)
    values[:, :, 4] = (
        np.cumsum(noise(7)[:, :, 4], axis=1) if slope > 0 else np.diff(noise(7)[:, :, 4], prepend=0.0)
    )
    values[:, :, 4] += 0.3 * wave(times(), 4.1 if slope > 0 else 0.7)
    found = line(times(), values, [False] * 4 + [True, False])
    assert found is not None
    assert found.hertz == pytest.approx(4.1 if slope > 0 else 0.7, abs=1e-3)
