"""JCGM 101 on the observations: the fit's rows are drawn and minimised again, by the model itself.

The residuals are written here a second time, from the model in docs/explanation/solving.md: those of the fits
are tested too.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.triad_calibration import reference_axes, scale_misalignment_bias
from procedures.geodesy import earth_rate_n
from procedures.statistics.least_squares import minimise
from procedures.twelve_positions.accelerometer_fit import TriadFit, specific_force

Residual = Callable[[FloatArray], FloatArray]
STEP_SIGMAS = 0.1  # for central differences
SAME_SIGMAS = 0.01  # of a parameter: negligible against the scatter that is looked at
COMPARED, STEPS = 4, 10


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
    """Return (draws, 15): k, E and D found from as many draws of the rows.

    The model bends by far less than a part in a hundred within some sigma: every draw takes the derivatives at the
    fit, and the first ones show that `minimise`, which takes them anew at every step, finds the same.
    """
    fit, found = joint.fit, []
    sigma = np.sqrt(np.diag(fit.covariance))
    base, ends = residual(fit.x), np.diag(STEP_SIGMAS * sigma)
    J = np.stack([(residual(fit.x + d) - residual(fit.x - d)) / (2 * STEP_SIGMAS) for d in ends], axis=1)
    back = np.linalg.pinv(J)
    for number in range(draws):
        noise = rng.standard_normal(len(base))
        x = _minimum(lambda x, noise=noise: residual(x) + noise, fit.x, sigma, back)  # type: ignore[misc]
        if number < COMPARED:
            again = minimise(lambda x, noise=noise: residual(x) + noise, fit.x, sigma * 1e3)  # type: ignore[misc]
            assert np.max(np.abs(again.x - x) / sigma) < SAME_SIGMAS
        axes = reference_axes(replace(joint, fit=replace(fit, x=x)), joint.bench.skew_seen)
        found.append(scale_misalignment_bias(x[:9].reshape(3, 3) @ axes, x[9:12], per)[0])
    return np.array(found)


def _minimum(residual: Residual, start: FloatArray, sigma: FloatArray, back: FloatArray) -> FloatArray:
    """Return where ``back`` (p, n), from residuals to parameters in sigmas, leaves the parameters as they are."""
    x = start
    for _ in range(STEPS):
        step = -back @ residual(x)
        x = x + sigma * step
        if np.max(np.abs(step)) < SAME_SIGMAS:
            return x
    raise AssertionError(f"not at rest after {STEPS} steps")
