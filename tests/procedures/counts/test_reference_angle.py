"""An encoder beside a turning gyroscope: mean rates are exact, its delay is found by its own sigma."""

import numpy as np
import pytest

from procedures.counts.reference_angle import SURE, lateness, mean_rates, unwrapped

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


def test_a_rate_that_never_changes_tells_no_delay() -> None:
    t = PERIOD * np.arange(4000)
    late, std = lateness(t, 20 * t, 20 * SCALE + 0.01 * np.random.default_rng(3).standard_normal(4000))
    assert abs(late) < SURE * std
