"""JCGM 101 on the observations: the fit's rows are drawn anew and minimised anew, nothing of it by linear gain.

The residuals are written here a second time, from the model in docs/solving.md: the fits' own are tested too.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.triad_calibration import reference_axes, scale_misalignment_bias
from procedures.dwells_and_turns.twelve_position import TriadFit, specific_force
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.statistics.least_squares import minimise

Residual = Callable[[FloatArray], FloatArray]
KEPT = 256  # residuals: every draw begins at the fit and takes the same differences there


def accelerometer_residual(joint: TriadFit) -> Residual:
    """Return the whitened rows of dwells and priors as a function of the parameters."""
    prior = joint.bench.priors()

    def residual(x: FloatArray) -> FloatArray:
        model = specific_force(joint.bench, x[12:]) @ x[:9].reshape(3, 3).T + x[9:12]
        dwells = ((joint.seen.rate - model) / joint.sigma).ravel()
        return np.concatenate((dwells, prior.matrix @ x[12:] - prior.mean))

    return residual


def gyroscope_residual(fits: CampaignFits) -> Residual:
    """Return the whitened rows of dwells, turns, priors and closures; those of priors are linear as they stand."""
    gyroscope = fits.gyroscope
    assert gyroscope is not None
    joint, turns, shapes = gyroscope.joint, gyroscope.turns, gyroscope.geometry
    n, bench, at_fit = len(joint.seen.dwells), joint.bench, joint.fit
    C_sb = bench.C_sb
    earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in bench.campaigns]
    motion = np.stack([np.eye(3)] * n + [shape.motion for shape in shapes])
    angle = np.degrees([shape.angle for shape in shapes])
    seconds = np.concatenate((np.ones(n), [turn.seconds for turn in turns]))
    observed = np.concatenate((joint.seen.rate, np.array([turn.total for turn in turns])))
    sigma, rows = np.concatenate((joint.sigma, gyroscope.turn_sigma)), 3 * (n + len(turns))

    def residual(x: FloatArray) -> FloatArray:
        tilts = x[12 : 12 + bench.size]
        u = bench.seen(tilts, earth, motion)
        u[n:] += (angle + x[12 + bench.size :])[:, None] * bench.to_cube(tilts)[n:, :, 2]
        model = (C_sb @ u[..., None])[..., 0] @ x[:9].reshape(3, 3).T + seconds[:, None] * x[9:12]
        known = at_fit.residual[rows:] + at_fit.jacobian[rows:] @ (x - at_fit.x)
        return np.concatenate((((observed - model) / sigma).ravel(), known))

    return residual


def drawn(
    joint: TriadFit, residual: Residual, draws: int, rng: np.random.Generator, per: float = 1.0
) -> FloatArray:
    """Return (draws, 15): k, E and D found from as many draws of the rows."""
    fit, found = joint.fit, []
    scale = np.sqrt(np.diag(fit.covariance)) * 1e3
    base = residual(fit.x)

    @lru_cache(KEPT)
    def known(x: bytes) -> FloatArray:
        return residual(np.frombuffer(x))

    for _ in range(draws):
        noise = rng.standard_normal(len(base))
        again = minimise(lambda x, noise=noise: known(x.tobytes()) + noise, fit.x, scale)  # type: ignore[misc]
        axes = reference_axes(replace(joint, fit=again), joint.bench.skew_seen)
        found.append(scale_misalignment_bias(again.x[:9].reshape(3, 3) @ axes, again.x[9:12], per)[0])
    return np.array(found)
