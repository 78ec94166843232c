"""Seating: how a face's tilt on the plate varies between placements, as the accelerometers see it.

A move carries one seat into the next; a seat of 1 arcsec is worth 1.5 ppm of a flip. The accelerometers measure
every placement's tilt to 0.1 ug; what they cannot determine is a face's tilt from the mean seat of its placements.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import cross_axes, face_normal, face_of
from procedures.statistics.least_squares import Fit, joined_rows
from procedures.twelve_positions.accelerometer_fit import (
    TURN_ON_STEP_STD_G,
    TriadFit,
    fit_with_turn_ons,
    gravity_n,
)

SEATING_SCALE_RAD = 0.1  # rad, at which a seat bends the model


def seating_rotations(positions: Sequence[int]) -> FloatArray:
    """Return (n, 3, 2): takes a seat's two tilts [rad] to the rotation vector of the cube in a position 1..24."""
    rows = list[FloatArray]()
    for position in positions:
        face = face_of(position)
        rows.append(np.stack([np.cross(face_normal(face), np.eye(3)[k]) for k in cross_axes(face)], axis=1))
    return np.stack(rows)


def seated(accelerometer: TriadFit, seat: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the accelerometers say of bench and seats, (p + 2 n,) [rad], its covariance and its `gain`.

    ``accelerometer`` is their fit of n dwells, in which all seats are alike; ``seat`` (n,) [rad] is 1 sigma of a
    seat. The p parameters are those of the bench that belong to no single placement. Steps of the bias between
    turn-ons are free here too: those found while all seats were alike hold what a seat did to its turn-on.
    """
    bench, seen = accelerometer.bench, accelerometer.seen
    shared, n, size = 12 + bench.shared, len(seat), len(accelerometer.fit.x)
    prior, sigma = bench.priors(), accelerometer.sigma
    leans = seating_rotations([at.position for at in bench.placements])
    spread = np.repeat(seat, 2)

    def residual(x: FloatArray, steps: FloatArray) -> FloatArray:
        at, K = x[..., 12:size], x[..., :9].reshape(*x.shape[:-1], 3, 3)
        turned = bench.attitudes(at, (leans @ x[..., size:].reshape(*x.shape[:-1], n, 2, 1))[..., 0])
        up = np.stack(gravity_n(bench, at), axis=-2)[..., [place.campaign for place in bench.placements], :]
        u = (bench.C_sb @ turned @ up[..., None])[..., 0]
        off = (seen.rate - steps - u @ np.swapaxes(K, -1, -2) - x[..., None, 9:12]) / sigma
        return joined_rows(x, off, at @ prior.matrix.T - prior.mean, x[..., size:] / spread)

    start = np.concatenate((accelerometer.fit.x, np.zeros(2 * n)))
    scale = np.full(len(start), SEATING_SCALE_RAD)
    scale[:12] = np.max(np.abs(accelerometer.fit.x[:12]))
    turn_ons = [(number, dwell.turn_on) for number, dwell in seen.dwells]
    fit = fit_with_turn_ons(residual, start, scale, turn_ons, TURN_ON_STEP_STD_G * accelerometer.k).fit
    kept = np.r_[12:shared, size : len(start)]
    return fit.x[kept], fit.covariance[np.ix_(kept, kept)], gain(fit, sigma)[kept]


def gain(fit: Fit, sigma: FloatArray) -> FloatArray:
    """Return the change (p, 3 n) of a fit's parameters with the n rates that its first rows are of.

    ``sigma`` (n, 3) is 1 sigma of the rates [output/s].
    """
    change: FloatArray = -fit.covariance @ fit.jacobian[: sigma.size].T / sigma.ravel()
    return change
