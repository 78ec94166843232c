"""Whether each dwell stands on the face and at the heading that its position names.

Faces: an affine fit of the outputs to the nominal attitudes must leave little, with each sensor along its axis.
Headings: at rest, turned by ``delta`` counter-clockwise from above, a triad of gyroscopes counts ``r = K C_sb
C_bl(p) Rz(-(alpha + delta)) w + b``, w the Earth's rate, alpha common to all. One Bayesian fit; without its prior
a heading is ``delta / (1 - h)``, of variance ``h std^2 / (1 - h)``, h the prior's leverage (deletion: Cook and
Weisberg 1982, 2.2). The two dwells of a face alone show the sum of their headings: both are named.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TriadDwells
from procedures.errors import FitsNoFace, WrongFace, WrongMounting
from procedures.frames import AXES
from procedures.geodesy import earth_rate_n
from procedures.gyrocompass import CertainDwell
from procedures.positions import FACES, face_normal, face_of, nominal_C_lb
from procedures.statistics.least_squares import Fit, minimise_if_determined
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.units import RAD_S_PER_DEG_H

T = TypeVar("T")
MAX_MISFIT_G = 0.2  # g, or unit vector: far above any tilt, far below a wrong face (1 g)


def refuse_wrong_faces(seen: TriadDwells, C_sb: Sequence[FloatArray]) -> None:
    """Raise `WrongFace`, `FitsNoFace` or `WrongMounting` where dwells contradict their positions.

    ``C_sb`` holds per campaign the rotation (3, 3) from the cube's axes to the IMU's. Fewer than four dwells,
    or dwells that fit any label, are let through: nothing contradicts them.
    """
    mounting = [C_sb[number] for number, _ in seen.dwells]
    faces = [face_of(dwell.position) for _, dwell in seen.dwells]
    if not _spans(mounting, faces) or not np.any(np.ptp(seen.rate, axis=0) > 0):
        return
    residual, E = _affine(seen.rate, mounting, faces)
    nearest = E.round()
    if max(residual, float(np.abs(E - nearest).max())) < MAX_MISFIT_G and abs(np.linalg.det(nearest)) == 1:
        if np.linalg.det(nearest) < 0 or np.array_equal(nearest, np.eye(3)):
            return  # one sensor that counts backwards is no mounting
        named, found = ([_axis_name(row) for row in C] for C in (mounting[0], nearest @ mounting[0]))
        raise WrongMounting(str(named), str(found))
    trials = [
        (_misfit(seen.rate, mounting, [*faces[:i], face, *faces[i + 1 :]]), i, face)
        for i in range(len(faces))
        for face in FACES
        if face != faces[i]
    ]
    best, i, face = min(trials)
    without = [
        _misfit(np.delete(seen.rate, k, axis=0), _but(mounting, k), _but(faces, k)) for k in range(len(faces))
    ]
    if best >= MAX_MISFIT_G > min(without):  # no face would mend the one dwell that spoils the rest
        odd = seen.dwells[int(np.argmin(without))][1]
        raise FitsNoFace(odd.name, odd.position)
    dwell = seen.dwells[i][1]
    raise WrongFace(dwell.name, dwell.position, faces[i], face)


def _but(items: list[T], k: int) -> list[T]:
    return [*items[:k], *items[k + 1 :]]


def _misfit(rate: FloatArray, mounting: Sequence[FloatArray], faces: Sequence[str]) -> float:
    """Return the worst of residual [g] and cross-axis E; infinite where the faces leave them open."""
    if not _spans(mounting, faces):
        return np.inf
    residual, E = _affine(rate, mounting, faces)
    return max(residual, float(np.abs(E * ~np.eye(3, dtype=bool)).max()))


def _spans(mounting: Sequence[FloatArray], faces: Sequence[str]) -> bool:
    u = np.stack([C @ face_normal(face) for C, face in zip(mounting, faces, strict=True)])
    return bool(np.linalg.matrix_rank(np.hstack((u, np.ones((len(u), 1)))), tol=0.1) == 4)


def _affine(rate: FloatArray, mounting: Sequence[FloatArray], faces: Sequence[str]) -> tuple[float, FloatArray]:
    """Return the worst residual [g] of an affine fit to nominal attitudes, and its E (3, 3).

    A sensor whose output hardly moves is dead, not misplaced: it is left out.
    """
    u = np.stack([C @ face_normal(face) for C, face in zip(mounting, faces, strict=True)])
    A = np.hstack((u, np.ones((len(u), 1))))
    solution, *_ = np.linalg.lstsq(A, rate, rcond=None)
    swing = np.ptp(rate, axis=0)
    alive = swing > MAX_MISFIT_G * swing.max()
    k = np.maximum(np.linalg.norm(solution[:3], axis=0), 1e-9 * swing.max())
    E = np.where(alive, solution[:3] / k, np.eye(3)).T
    return float((np.abs(rate - A @ solution)[:, alive] / k[alive]).max(initial=0.0)), E


def _axis_name(row: FloatArray) -> str:
    axis = int(np.argmax(np.abs(row)))
    return ("+" if row[axis] > 0 else "-") + AXES[axis]


MIN_ERROR_SIGMAS = 4.0
AMBIGUOUS_CHI2 = 9.0  # of chi2: a dwell whose heading explains nearly as much may be the one
UNKNOWN_HEADING_STD_RAD = 0.3  # rad, 1 sigma of a heading of which nothing is stated
BIAS_STD_RAD_S = 30 * RAD_S_PER_DEG_H  # rad/s, 1 sigma
SCALE_STD, MISALIGNMENT_STD_RAD = 0.1, 1e-2  # 1 sigma, where only a rough scale factor is known
CONTRADICTION_P_VALUE = 1e-4  # probability of a chi2 above which sigma is widened to what the dwells scatter by
SOLVED_K_STD = (1e-3, 1e-3)  # 1 sigma, relative, of K as turns and dwells determine it, with a bad heading in it
MAX_NAMED_DWELLS = 3  # dwells named at most: more of them are another matter than a slip
MAX_HEADING_ERROR_RAD = 0.5  # rad: a dwell that stood further off was taken for another position


@dataclass(frozen=True, slots=True)
class HeadingError:
    """Which of the dwells (their numbers) stood off: one, or one of several that cannot be separated.

    ``angle`` [rad] is counter-clockwise seen from above against the marks, if it was the first; with 1 sigma.
    """

    dwells: tuple[int, ...]
    angle: float
    std: float


def heading_errors(
    dwells: Sequence[CertainDwell], latitude: float, C_sb: FloatArray, K: FloatArray, heading_std: float,
    ranges: tuple[float, float] = (SCALE_STD, MISALIGNMENT_STD_RAD),
) -> list[HeadingError]:  # fmt: skip
    """Name the dwells that stood turned, the clearest first; none where the gyros cannot decide.

    ``C_sb`` (3, 3) takes the cube's axes to the IMU's. ``K`` (3, 3) [count/rad] is what the gyros count, IMU axes,
    known to ``ranges``: scale factor and misalignment, relative, 1 sigma. ``latitude`` and ``heading_std`` in rad.
    """
    if not len(dwells):  # a campaign of turns alone, next to one that has the positions
        return []
    stds, found = np.full(len(dwells), heading_std), list[tuple[int, ...]]()
    fit, ratio = None, 1.0
    while len(found) <= MAX_NAMED_DWELLS and (fit := _fit(dwells, latitude, C_sb, K, stds, ranges)) is not None:
        gain = _gain(fit, len(dwells))
        gain[[each[0] for each in found]] = 0.0
        order = np.argsort(-gain)
        best = gain[order[0]]
        if (
            len(found) == MAX_NAMED_DWELLS
            or not best > (MIN_ERROR_SIGMAS * fit.birge_ratio(3 * len(dwells), CONTRADICTION_P_VALUE, best)) ** 2
        ):
            ratio = fit.birge_ratio(3 * len(dwells), CONTRADICTION_P_VALUE)
            break
        found.append(tuple(int(i) for i in order if gain[i] > best - AMBIGUOUS_CHI2 and gain[i] > 0))
        stds[found[-1][0]] = UNKNOWN_HEADING_STD_RAD
    if fit is None:
        return []
    angles = fit.x[-len(dwells) :]
    own = ratio * np.sqrt(np.diag(fit.covariance)[-len(dwells) :])
    if any(abs(angles[each[0]]) > MAX_HEADING_ERROR_RAD for each in found):
        return []
    errors = [HeadingError(each, float(angles[each[0]]), float(own[each[0]])) for each in found]
    return [one for one in errors if abs(one.angle) > MIN_ERROR_SIGMAS * np.hypot(one.std, heading_std)]


def heading_warnings(campaigns: Sequence[Campaign], joint: TriadFit) -> tuple[list[str], list[str]]:
    """Return the dwells that stood turned against the marks, campaign by campaign: each in words; sure names."""
    K, text, sure = np.degrees(joint.fit.x[:9].reshape(3, 3)), list[str](), list[str]()
    for number, campaign in enumerate(campaigns):
        rows = [i for i, (of, _) in enumerate(joint.seen.dwells) if of == number]
        records = [joint.seen.dwells[i][1] for i in rows]
        known = [
            CertainDwell(record.position, joint.seen.rate[i], joint.expected[i])
            for i, record in zip(rows, records, strict=True)
        ]
        errors = heading_errors(
            known, campaign.site.latitude, campaign.fixture.C_sb, K, campaign.sigma.heading, SOLVED_K_STD
        )
        for error in errors:
            named = " or ".join(f"{records[i].position} ({records[i].name})" for i in sorted(error.dwells))
            text.append(f"position {named} {heading_error_text(error)}: record it again")
            sure += [records[i].name for i in error.dwells if len(error.dwells) == 1]
    return text, sure


def heading_error_text(error: HeadingError) -> str:
    """Return a heading error in words: angle, direction, sigma."""
    way = "counter-clockwise" if error.angle > 0 else "clockwise"
    angle, std = np.degrees(abs(error.angle)), np.degrees(error.std)
    return f"has a heading error of {angle:.1f} deg, {way} from above, by the Earth rate (u = {std:.1g} deg)"


def _gain(fit: Fit, n: int) -> FloatArray:
    """Return by how much chi2 (n,) would fall if nothing were stated of each dwell's heading."""
    residual, leverage = fit.residual[-n:], fit.leverage[-n:]
    return np.where(leverage < 1 - 1e-9, residual**2 / np.maximum(1 - leverage, 1e-9), 0.0)


def _fit(
    dwells: Sequence[CertainDwell], latitude: float, C_sb: FloatArray, K: FloatArray, stds: FloatArray,
    ranges: tuple[float, float],
) -> Fit | None:  # fmt: skip
    """Fit K (9), b (3), alpha and the headings, in units of the scale factors and the Earth's rate."""
    k = np.linalg.norm(K, axis=1)
    C = np.array([C_sb @ nominal_C_lb(each.position).T for each in dwells])
    _, level, up = earth_rate_n(latitude)
    unit = float(np.hypot(level, up))
    rate = np.array([each.rate for each in dwells]) / (k * unit)
    std = np.array([each.std for each in dwells]) / (k * unit)
    start_K = K / k[:, None]
    width = np.where(np.abs(start_K) > 0.5, *ranges)

    def residual(x: FloatArray) -> FloatArray:
        turned = x[12] + x[13:]
        w = np.column_stack((level * np.sin(turned), level * np.cos(turned), np.full(len(dwells), up))) / unit
        model = (C @ w[..., None])[..., 0] @ x[:9].reshape(3, 3).T + x[9:12]
        return np.concatenate(
            (
                ((rate - model) / std).ravel(),
                (x[:9] - start_K.ravel()) / width.ravel(),
                x[9:12] / (BIAS_STD_RAD_S / unit),
                x[12:13] / UNKNOWN_HEADING_STD_RAD,
                x[13:] / stds,
            )
        )

    start = np.concatenate((start_K.ravel(), np.zeros(4 + len(dwells))))
    return minimise_if_determined(residual, start, np.ones(len(start)))
