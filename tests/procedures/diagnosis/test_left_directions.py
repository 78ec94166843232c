"""What is left along a curve of time is seen; noise goes with nothing."""

import numpy as np
import pytest

from procedures.diagnosis.left_directions import families, worst_direction
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import KINDS, Evidence
from procedures.effects.effect import Columns, per_axis
from tests.procedures.diagnosis.redrawn import redrawn, seen_by

SIGMAS = 7.0


def looked(evidence: Evidence) -> tuple[str, float]:
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    found = worst_direction(evidence, fit)
    assert found is not None
    return f"{found.triad} {found.what}", found.log_p


@pytest.mark.parametrize("design", ["plain", "free"])
def test_noise_goes_with_nothing(design: str) -> None:
    _, evidence, _ = seen_by(design)
    rng = np.random.default_rng(5)
    p = np.exp([looked(redrawn(evidence, rng))[1] for _ in range(60)])
    assert np.sum(p < 0.05) <= 8  # binomial of 60: more is one in 200
    assert np.sum(p < 0.01) <= 4


def test_a_curve_of_time_on_one_sensor_is_seen() -> None:
    _, evidence, _ = seen_by("plain")
    seen, rng = evidence.excitation, np.random.default_rng(6)
    wave = np.cos(np.pi * 8 * (seen.t - seen.t.min()) / np.ptp(seen.t))
    H = evidence.column(Columns(("x", "y", "z"), accel=per_axis(wave)))[:, 1]
    fit = fit_linear(evidence, [], factor=np.ones(len(H)))
    wide = np.concatenate((H / evidence.sigma, np.zeros(len(fit.whole) - len(H))))
    added = SIGMAS * H / np.linalg.norm(wide - fit.Q @ (fit.Q.T @ wide))
    found = [looked(redrawn(evidence, rng, added)) for _ in range(10)]
    along = sum(what.startswith("accelerometer") and log_p < np.log(0.01) for what, log_p in found)
    assert along >= 8


def test_only_the_triad_that_is_asked_for_is_looked_at() -> None:
    _, evidence, _ = seen_by("plain")
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    found = worst_direction(evidence, fit, "gyroscope")
    assert found is not None
    assert found.triad == "gyroscope"


def test_the_position_before_the_first_is_the_first_itself_wherever_it_is_asked_for() -> None:
    _, evidence, _ = seen_by("plain")
    seen = evidence.excitation
    first = ~np.isfinite(seen.change).any(axis=1)
    assert first.any()
    np.testing.assert_array_equal(seen.f_before[first], seen.f[first])
    np.testing.assert_array_equal(seen.f_before[~first], (seen.f - seen.change)[~first])
    H = next(H for what, of, H in families(evidence) if (what, of) == ("the position before", "accelerometer"))
    resting = np.array([step.kind != "turn" for step in seen.steps])[seen.step]
    values = np.concatenate([per_axis(seen.f_before[:, i] * resting) for i in range(3)], axis=2)
    expected = evidence.column(Columns(tuple("abcdefghi"), accel=values)) / evidence.sigma[:, None]
    np.testing.assert_allclose(H[:, :9], expected, atol=1e-8)
    of_first = np.isin(evidence.step, seen.step[first])
    assert not H[~of_first, 9:].any()
    assert H[of_first & (evidence.triad == 0), 9:].any()  # how it stood before is not known: a constant of its own


def test_the_warmth_of_turning_is_looked_at_and_fades_at_rest() -> None:
    _, evidence, _ = seen_by("plain")
    H = {what: H for what, of, H in families(evidence) if of == "gyroscope"}["warmth of turning, x"]
    seen = evidence.excitation
    dwells = (evidence.kind == KINDS.index("mean")) & (evidence.triad == 1) & (evidence.axis == 0)
    begun = np.array([seen.t[seen.step == number].min() for number in range(len(seen.steps))])
    turned = max((begun[i] for i, step in enumerate(seen.steps) if step.kind == "turn"), default=-np.inf)
    before = dwells & (begun[evidence.step] < min(begun[i] for i, s in enumerate(seen.steps) if s.kind == "turn"))
    assert not H[before].any()  # nothing has turned yet
    after = np.flatnonzero(dwells & (begun[evidence.step] > turned))
    order = after[np.argsort(begun[evidence.step[after]])]
    warm = (H * evidence.sigma[:, None])[order, 0]
    assert np.all(np.diff(warm) < 0)
