"""What is left along a curve of time is seen; noise goes with nothing."""

import numpy as np
import pytest

from procedures.diagnosis.left_directions import worst_direction
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import Evidence
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
