"""Residuals of dwells and rotations in natural units, the global test, and warnings about turn-ons."""

from collections.abc import Sequence

import numpy as np
from scipy.special import gammaincc

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import FitQuality, StepResidual
from procedures.campaign.campaign import Campaign
from procedures.free_positions.gyroscopes_from_moves import MovesFit
from procedures.twelve_positions.accelerometer_fit import RestFit, TriadFit
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit
from procedures.units import DEG_H_PER_DEG_S, RAD_PER_ARCSEC, UG_PER_G

# A residual whose sigma is less than a thousandth of the observation's is the fit's, not the data's
MIN_FREE_VARIANCE = 1e-6


def dwell_residuals(joint: TriadFit) -> tuple[FloatArray, FloatArray]:
    """Return residual (n, 3) and its 1 sigma, in input units (g, deg/s), of every dwell."""
    n = len(joint.seen.dwells)
    sigma = joint.sigma / joint.k
    free = np.sqrt(np.maximum(1 - joint.fit.leverage[: 3 * n].reshape(n, 3), MIN_FREE_VARIANCE))
    return joint.fit.residual[: 3 * n].reshape(n, 3) * sigma, sigma * free


def step_residuals(accelerometer: TriadFit | None, gyroscope: GyroscopeFit | None) -> tuple[StepResidual, ...]:
    """Return every dwell's and turn's residual, accelerometers first."""
    found: list[StepResidual] = []
    gyro = gyroscope.joint if gyroscope else None
    triads = ("accelerometer", accelerometer, 1.0, "g"), ("gyroscope", gyro, DEG_H_PER_DEG_S, "deg/h")
    for triad, joint, per, unit in triads:
        if joint is not None:
            for (_, dwell), r, s in zip(joint.seen.dwells, *dwell_residuals(joint), strict=True):
                found.append(StepResidual(dwell.name, "dwell", triad, dwell.position, r * per, s * per, unit))
    return (*found, *(_turn_residuals(gyroscope) if gyroscope else ()), *(_move_residuals(gyroscope)))


def _turn_residuals(gyroscope: GyroscopeFit) -> list[StepResidual]:
    """Residual (3,) of every turn [deg]; the closure is part of the fit, so what is left is smaller than it."""
    joint, found = gyroscope.joint, []
    for i, turn in enumerate(gyroscope.turns):
        first = 3 * (len(joint.seen.dwells) + i)
        rows = slice(first, first + 3)
        sigma = gyroscope.turn_sigma[i] / joint.k
        free = np.sqrt(np.maximum(1 - joint.fit.leverage[rows], MIN_FREE_VARIANCE))
        residual, std = joint.fit.residual[rows] * sigma, sigma * free
        start = turn.record.start_position
        found.append(StepResidual(turn.record.name, "turn", "gyroscope", start, residual, std, "deg"))
    return found


def _move_residuals(gyroscope: GyroscopeFit | None) -> list[StepResidual]:
    """Residual (3,) of every move's rotation [arcsec], in the IMU's axes at its end."""
    if gyroscope is None or gyroscope.moves is None:
        return []
    moves = gyroscope.moves
    free = np.maximum(1 - gyroscope.joint.fit.leverage[moves.rows].reshape(-1, 3), MIN_FREE_VARIANCE)
    std = moves.sigma[:, None] * np.sqrt(free) / RAD_PER_ARCSEC
    records = moves.moves.records
    return [
        StepResidual(record.name, "move", "gyroscope", 0, error / RAD_PER_ARCSEC, row, "arcsec")
        for record, error, row in zip(records, moves.error, std, strict=True)
    ]


def fit_quality(
    accelerometer: TriadFit | None, gyroscope: TriadFit | None, moves: MovesFit | None = None
) -> FitQuality:
    """Return the global test over counting noise alone: what scatters more than it does not pass unseen.

    What the campaign itself states of an unsettled unit is expected.
    """
    parts = chi2_by_part(accelerometer, gyroscope, moves).values()
    chi2, dof = sum(each for each, _ in parts), sum(each for _, each in parts)
    gyroscope_rms = _rms(gyroscope) if gyroscope else None
    if moves is not None:
        gyroscope_rms = float(np.sqrt(np.mean(moves.rate_error**2)))
    return FitQuality(
        chi2=float(chi2),
        dof=dof,
        p_value=p_value_of(chi2, dof),
        accelerometer_rms_g=_rms(accelerometer) if accelerometer else None,
        gyroscope_rms_dph=gyroscope_rms * DEG_H_PER_DEG_S if gyroscope_rms is not None else None,
    )


def chi2_by_part(
    accelerometer: TriadFit | None, gyroscope: TriadFit | None, moves: MovesFit | None
) -> dict[str, tuple[float, int]]:
    """Return chi-square and degrees of freedom of each part of a solve that is there, by its name."""
    fits = {"accelerometers": accelerometer, "gyroscopes": gyroscope}
    found = {name: (_chi2(fit), fit.dof) for name, fit in fits.items() if fit is not None}
    return found | ({"gyroscopes in the transfers": (moves.chi2, moves.dof)} if moves is not None else {})


def p_value_of(chi2: float, dof: int) -> float:
    """Return the probability of a chi-square as large or larger by noise alone."""
    return float(gammaincc(dof / 2, chi2 / 2)) if dof > 0 else 1.0


def _chi2(joint: TriadFit) -> float:
    rows = joint.fit.residual.copy()
    rows[: joint.seen.std.size] *= np.sqrt(1 + (joint.excess / joint.expected) ** 2).ravel()
    if joint.rests is not None:
        rows[joint.rests.rows] *= joint.rests.sigma / joint.rests.noise
    return float(rows @ rows)


def _rms(joint: TriadFit) -> float:
    rows = [dwell_residuals(joint)[0].ravel()]
    if joint.rests is not None:
        rows.append(norm_residuals(joint.rests, joint.fit.residual))
    return float(np.sqrt(np.mean(np.concatenate(rows) ** 2)))


def norm_residuals(rests: RestFit, residual: FloatArray) -> FloatArray:
    """Return by how much every rest's specific force is longer than gravity (n,) [g].

    ``residual`` (m,) is the whitened one of the fit that ``rests`` are part of.
    """
    return residual[rests.rows] * rests.sigma


def turn_on_warnings(
    campaigns: Sequence[Campaign], accelerometer: TriadFit | None, gyroscope: GyroscopeFit | None
) -> list[str]:
    """Say which bias the solution has, and by how much turn-ons differed; nothing of campaigns with one."""
    times = max(_turn_ons(each) for each in campaigns)
    if times < 2:
        return []
    triads = (
        ("accelerometer", accelerometer, "ug", UG_PER_G),
        ("gyroscope", None if gyroscope is None else gyroscope.joint, "deg/h", DEG_H_PER_DEG_S),
    )
    parts = list[str]()
    for name, joint, unit, per in triads:
        if joint is not None and joint.profiled:
            spread = joint.spread / joint.k * per
            parts.append(f"{name} {', '.join(f'{each:.2g}' for each in spread)} {unit}")
        elif joint is not None:
            parts.append(f"{name} not separated: one bias was solved for all")
    return [
        f"the unit was switched on {times} times within a campaign: each power-on has its own biases, and the "
        f"bias here is their mean; u of the mean x, y, z: {'; '.join(parts)}, included in its uncertainty"
    ]


def _turn_ons(campaign: Campaign) -> int:
    return len({dwell.turn_on for dwell in campaign.dwells} | {turn.turn_on for turn in campaign.turns})
