"""A clock's rate from stamps that were read late, latched by a pulse, cut to seconds, or stepped in between."""

from collections.abc import Callable

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.encoder_angle import SURE, lateness, mean_rates, unwrapped
from procedures.counts.reference_time import fit_clock
from procedures.statistics.line_fits import fit_correlated_line
from tests.procedures.counts.recorded_delays import LAYOUTS, campaign, read_traces

TRACES = read_traces()
DWELLS, DWELL_S, PAUSE_S = 12, 30.0, 10.0


def stamped(ppm: float, late: Callable[[FloatArray], FloatArray]) -> list[tuple[FloatArray, FloatArray]]:
    """Return device time and reference time [s] of dwells, the reference ``late`` (n,) [s] at true times."""
    begin = (DWELL_S + PAUSE_S) * np.arange(DWELLS)
    true = [each + np.arange(0.0, DWELL_S, 0.06) for each in begin]
    return [((1 + 1e-6 * ppm) * each, 1.7e9 + each + late(each)) for each in true]


@pytest.mark.parametrize("loads", [(0,), (1, 2), (4, 8), (15,)])
def test_on_a_busy_machine_no_rate_is_invented_and_a_true_one_is_found(loads: tuple[int, ...]) -> None:
    traces = [trace for trace in TRACES if trace.load in loads]
    z = list[float]()
    for i in range(8):
        ppm = (0.0, 50.0, -50.0, 0.0)[i % 4]
        rate = fit_clock(campaign(traces, *LAYOUTS[i % 2], ppm, np.random.default_rng([3, i])))
        assert rate is not None
        z.append((rate.ppm - ppm) / rate.std)
        if ppm and max(loads) <= 2:
            assert abs(rate.ppm) > 4 * rate.std
    assert np.max(np.abs(z)) < 4
    assert 0.3 < np.sqrt(np.mean(np.square(z))) < 2.0  # of eight


@pytest.mark.parametrize("memory", [0.0, 0.3, 0.6, 0.8])
def test_errors_that_hang_together_are_in_the_sigma(memory: float) -> None:
    rng, x, z = np.random.default_rng(1), np.arange(24.0), list[float]()
    for _ in range(300):
        noise = rng.standard_normal(24)
        for i in range(1, 24):
            noise[i] = memory * noise[i - 1] + np.sqrt(1 - memory**2) * noise[i]
        line = fit_correlated_line(x, noise, np.zeros(24, dtype=np.int64))
        assert line is not None
        z.append(line.slope / line.std)
    assert 0.55 < np.std(z) < 1.5


@pytest.mark.parametrize("seed", range(2))
def test_a_pulse_that_errs_to_both_sides_is_used_to_its_full_worth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rate = fit_clock(stamped(37.0, lambda true: 1e-3 * rng.standard_normal(len(true))))
    assert rate is not None
    assert abs(rate.ppm - 37.0) < 4 * rate.std
    assert rate.std < 0.3  # 1 ms over the root of 6000 rows, 140 s: 0.1 ppm


@pytest.mark.parametrize("ppm", [0.0, 37.0, -50.0, 1000.0])
def test_whole_seconds_show_no_more_than_the_moment_they_go_on(ppm: float) -> None:
    rate = fit_clock(stamped(ppm, lambda true: np.floor(true) - true))
    assert rate is not None
    assert abs(rate.ppm - ppm) < 4 * rate.std
    assert rate.std > 0.06 / np.sqrt(6) / 480 * 1e6 * 0.9


@pytest.mark.parametrize("leap", [1.0, -1.0, 5000.0])
def test_a_reference_that_is_set_between_two_dwells_does_not_bend_the_rate(leap: float) -> None:
    rng = np.random.default_rng(2)
    rate = fit_clock(stamped(20.0, lambda true: 1e-3 * rng.exponential(size=len(true)) + leap * (true > 375)))
    assert rate is not None
    assert abs(rate.ppm - 20.0) < 4 * rate.std < 10


@pytest.mark.parametrize("step", [2e-3, 0.3, 1.5, -0.02])
@pytest.mark.parametrize("at_s", [235.0, 250.0])  # between two dwells, inside one
def test_a_delay_that_changes_once_is_no_rate(step: float, at_s: float) -> None:
    for seed, ppm in enumerate((0.0, 50.0, -50.0)):
        rng = np.random.default_rng(seed)
        rate = fit_clock(stamped(ppm, lambda true: 1e-3 * rng.exponential(size=len(true)) + step * (true > at_s)))  # noqa: B023
        assert rate is not None
        assert abs(rate.ppm - ppm) < 4 * rate.std < 5


def test_a_device_that_was_switched_off_in_between_has_one_rate_still() -> None:
    rng = np.random.default_rng(3)
    pieces = stamped(20.0, lambda true: 1e-3 * rng.exponential(size=len(true)))
    restarted = [(t - t[0] if i == 6 else t - pieces[6][0][0], u) for i, (t, u) in enumerate(pieces) if i >= 6]
    rate = fit_clock([*pieces[:6], *restarted])
    assert rate is not None
    assert abs(rate.ppm - 20.0) < 4 * rate.std < 20


# An encoder next to a rotating gyroscope


SCALE, BIAS, PERIOD = 1.02, 0.01, 0.01


def log(seed: int, late_s: float, noise: float = 0.02, encoder_deg: float = 0.003) -> tuple[np.ndarray, ...]:
    """Return uneven times, an encoder that is late and wraps, and outputs; the angle is known in closed form."""
    rng = np.random.default_rng(seed)
    t = np.sort(PERIOD * (np.arange(6000) + rng.uniform(-0.3, 0.3, 6000)))

    def angle(at: np.ndarray) -> np.ndarray:
        return 300 * (1 - np.cos(0.3 * at)) + 15 * at

    rate = 90 * np.sin(0.3 * t) + 15
    encoder = np.mod(angle(t - late_s) + encoder_deg * rng.standard_normal(len(t)), 360.0)
    return t, encoder, SCALE * rate + BIAS + noise * rng.standard_normal(len(t))


def test_mean_rates_give_scale_factor_and_bias_though_the_encoder_wraps_and_rows_are_uneven() -> None:
    t, encoder, output = log(1, 0.0, noise=0.0, encoder_deg=0.0)
    found = mean_rates(t, unwrapped(encoder), output[:, None])
    k, b = np.polyfit(found.reference, found.values[:, 0], 1)
    assert k == pytest.approx(SCALE, rel=1e-6)
    assert b == pytest.approx(BIAS, abs=1e-4)
    assert t[0] < found.t[0] < found.t[-1] < t[-1]


@pytest.mark.parametrize("late_s", [0.0, 0.043, -0.31])
def test_a_delay_is_found_within_its_own_sigma(late_s: float) -> None:
    off = list[float]()
    for seed in range(20):
        t, encoder, output = log(seed, late_s)
        late, std = lateness(t, unwrapped(encoder), output)
        off.append((late - late_s) / std)
        assert (abs(late) > SURE * std) == (late_s != 0)
    assert np.max(np.abs(off)) < 4
    assert np.std(off) > 0.3


def test_a_rate_that_never_changes_shows_no_delay() -> None:
    t = PERIOD * np.arange(4000)
    late, std = lateness(t, 20 * t, 20 * SCALE + 0.01 * np.random.default_rng(3).standard_normal(4000))
    assert abs(late) < SURE * std
