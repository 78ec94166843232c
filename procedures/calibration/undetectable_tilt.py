"""Positions in which a tilt of the cube would not be detected, and the error that it would cause.

Internal and external reliability of W. Baarda (A testing procedure for use in geodetic networks, Netherlands
Geodetic Commission, 1968): with the whitened design A of all rows, P the projection on its columns and G the rows
that a tilt of one dwell changes, a tilt d shows by ``d' G' (1 - P) G d`` in chi2 and moves parameters by ``A^+ G
d``.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from procedures.arrays import FloatArray
from procedures.campaign.campaign import DwellRecord
from procedures.frames import AXES
from procedures.positions import position_name
from procedures.twelve_positions.accelerometer_fit import TriadFit, specific_force
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit
from procedures.twelve_positions.placement_transfers import seating_rotations
from procedures.units import RAD_PER_ARCSEC

HARMFUL = 1.2  # sigmas of a value by a tilt that shows by one; twelve positions that all count have 1.05
SEATS = 3.0  # times a seat's 1 sigma: tilts below are what placement and placement differ by
ANY_TILT_RAD = 1e-3  # from which on a tilt is any: no face of a cube tilts so
LEAST_SEEN = 1e-9  # share of a tilt that is taken to show: of a dwell alone in its turn-on neither shows nor moves
RANK = 1e-10  # of the largest pivot, below which a column of the design says nothing new
LEAST_MOVED = 1.0  # sigmas of a value: a dwell whose tilt moves nothing so far needs no word
KINDS = ("scale factor", "misalignment", "bias")
VALUES = [f"{KINDS[a != b]} {a if a == b else a + b}" for a in AXES for b in AXES] + [f"bias {a}" for a in AXES]


@dataclass(frozen=True, slots=True, eq=False)
class UndetectableTilt:
    """The ``tilt`` [rad] of one dwell that shows every second time, and what it makes wrong in that time.

    It, or one of `ANY_TILT_RAD` if that is less, moves ``value``, as ``accelerometer misalignment xy``, by
    ``sigmas`` of its own, seats' scatter in; tilts in other directions that show alike move no other by more.
    ``harmed`` names the accelerometers' values that one moves by more than `HARMFUL` times what shows and that is
    larger than `SEATS`, of which ``largest`` [rad] is the largest; ``is_of_moves`` says that one does so to the
    gyroscopes, by moves from or to the dwell. ``campaign`` counts from 0.
    """

    campaign: int
    step: str
    position: int
    tilt: float
    value: str
    sigmas: float
    harmed: tuple[str, ...] = ()
    is_of_moves: bool = False
    largest: float = 0.0


def undetectable_tilt_warnings(tilts: Sequence[UndetectableTilt]) -> list[str]:
    """Say in which positions debris would not be noticed, how large it may be, and what it would make wrong."""
    of_accelerometer = [each for each in tilts if each.harmed]
    of_gyroscope = [each for each in tilts if each.is_of_moves]
    parts = list[str]()
    if of_accelerometer:
        parts.append(f"in {_places(of_accelerometer)}: accelerometer {_values(of_accelerometer)} would be wrong")
    if of_gyroscope:
        what = "gyroscope scale factor and misalignment would be wrong by the transfers from and to there"
        parts.append(f"in {_places(of_gyroscope)}: {what}")
    if not parts:
        return []
    advice = "record both positions of these faces, until every channel shows a count edge, without power-off"
    return [f"debris under the cube would not be detected {'; '.join(parts)}; {advice}"]


def undetectable_tilts(
    accelerometer: TriadFit,
    gyroscope: GyroscopeFit | None,
    noticed: float,
    tilted: Collection[tuple[int, str]] = (),
) -> tuple[UndetectableTilt, ...]:
    """Return by how far the cube may tilt unnoticed in each dwell, and what that makes wrong.

    Dwells whose tilt moves nothing by `LEAST_MOVED` are left out.

    ``noticed`` [sigma] is by how much a tilt shows (`FitQuality.noticed_sigmas`), ``tilted`` are the number of the
    campaign and the name of each dwell whose seat was found: nothing else of it is known.
    """
    if not (dwells := accelerometer.seen.dwells):
        return ()  # rests alone
    by_tilt = _rows_by_tilt(accelerometer)
    is_tilted = [(number, dwell.name) in tilted for number, dwell in dwells]
    solved = _Solved.of(accelerometer, by_tilt, by_tilt[is_tilted])
    found = list[UndetectableTilt]()
    for i, (number, dwell) in enumerate(dwells):
        if not is_tilted[i]:
            tilts, harm = solved.reliability(i, _gyroscopes_by_tilt(gyroscope, number, dwell.name))
            seat = accelerometer.bench.campaigns[number].sigma.seat
            moved = np.nan_to_num(harm * noticed)
            found.append(_of_dwell(number, dwell, tilts * noticed, moved, noticed * HARMFUL, SEATS * seat))
    return tuple(each for each in found if each.sigmas >= LEAST_MOVED or each.harmed or each.is_of_moves)


def _of_dwell(
    campaign: int, dwell: DwellRecord, tilts: FloatArray, moved: FloatArray, harmful: float, least: float
) -> UndetectableTilt:
    """Return what is known of tilts (21,) [rad] that show; by how many sigmas each ``moved`` its value (21,)."""
    is_harmed = (moved > harmful) & (tilts > least)
    at_most = moved * np.minimum(1.0, ANY_TILT_RAD / np.maximum(tilts, ANY_TILT_RAD))
    worst = int(np.argmax(at_most))
    harmed = tuple(VALUES[k] for k in np.flatnonzero(is_harmed[: len(VALUES)]))
    value = f"accelerometer {VALUES[worst]}" if worst < len(VALUES) else f"gyroscope {VALUES[worst - len(VALUES)]}"
    return UndetectableTilt(
        campaign, dwell.name, dwell.position, float(tilts[worst]), value, float(at_most[worst]), harmed,
        bool(is_harmed[len(VALUES) :].any()), float(tilts[is_harmed].max(initial=0.0)),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    """Rows ``by_tilt`` (n, m, 2) of the tilts of n dwells, and of the design's m rows, whitened with the seats in.

    ``basis`` (m, r) spans the design; ``inverse`` (12, m) takes rows to K and b, in their own sigmas;
    to b of one turn-on only: of several it is the mean, whose sigma grows with what a tilt makes of a step.
    """

    by_tilt: FloatArray
    basis: FloatArray
    inverse: FloatArray

    @classmethod
    def of(cls, fit: TriadFit, by_tilt: FloatArray, taken: FloatArray) -> "_Solved":
        """Take the design of a fit, and the tilts ``taken`` (k, m, 2) [rad] that are solved for as well."""
        seats = np.array([fit.bench.campaigns[number].sigma.seat for number, _ in fit.seen.dwells])
        own = np.array([rows[3 * i : 3 * i + 3] for i, rows in enumerate(by_tilt)])
        wider = np.sqrt(1 + seats[:, None] ** 2 * np.sum(own**2, axis=2))
        less = np.concatenate((1 / wider.ravel(), np.ones(len(fit.fit.residual) - wider.size)))
        design = np.hstack((fit.fit.jacobian, *([fit.absorbed] if fit.profiled else []), *taken)) * less[:, None]
        Q, R, order = qr(design / np.linalg.norm(design, axis=0), mode="economic", pivoting=True)
        rank = int(np.count_nonzero(np.abs(np.diag(R)) > RANK * np.abs(R[0, 0])))
        back = np.zeros((design.shape[1], len(design)))
        back[order[:rank]] = np.linalg.solve(R[:rank, :rank], Q[:, :rank].T)
        std = np.linalg.norm(back[:12], axis=1)[:, None]
        inverse = np.divide(back[:12], std, out=np.zeros((12, len(design))), where=std > 0)  # 0: by priors alone
        inverse[9:] *= not fit.profiled
        return cls(by_tilt * less[:, None], Q[:, :rank], inverse)

    def reliability(self, i: int, gyroscopes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return tilts (21,) [rad] of a dwell that show by 1 sigma and do most to a value each, and what [sigma].

        Of the accelerometers' K and b, and the gyroscopes' K, moved by ``gyroscopes`` (9, 2) [sigma/rad].
        """
        G = self.by_tilt[i]
        seen = self.basis.T @ G
        shown = G.T @ G - seen.T @ seen + LEAST_SEEN * np.sum(G**2) * np.eye(2)
        does = np.vstack((self.inverse @ G, gyroscopes))
        worst = np.linalg.solve(shown, does.T).T  # of tilts that show alike, in the direction that does most
        harm = np.sqrt(np.sum(does * worst, axis=1))
        tilts = np.linalg.norm(worst, axis=1) / np.maximum(harm, np.finfo(float).tiny)
        return tilts, harm


def _rows_by_tilt(fit: TriadFit) -> FloatArray:
    """Return (n, m, 2): what a tilt of each dwell's cube, its seat, changes of the m whitened rows, per rad."""
    force = specific_force(fit.bench, fit.fit.x[12 : 12 + fit.bench.size])
    axes = np.swapaxes(fit.bench.C_sb @ seating_rotations([at.position for at in fit.bench.placements]), 1, 2)
    rows = np.zeros((len(force), len(fit.fit.residual), 2))
    for i, sigma in enumerate(fit.sigma):
        rows[i, 3 * i : 3 * i + 3] = (np.cross(axes[i], force[i]) @ fit.K.T / sigma).T
    return rows


def _gyroscopes_by_tilt(fit: GyroscopeFit | None, campaign: int, dwell: str) -> FloatArray:
    """Return (9, 2) by how many of its sigmas a dwell's tilt moves each element of the gyroscopes' K, per rad.

    By moves from and to it: seats are parameters of their fit, and K goes with a seat as their covariance says.
    """
    if fit is None or fit.moves is None:
        return np.zeros((9, 2))
    names = [(number, each.name) for number, each in fit.joint.seen.dwells]
    if (campaign, dwell) not in names:
        return np.zeros((9, 2))
    C, first = fit.joint.fit.covariance, 12 + fit.joint.bench.size + len(fit.turns)
    seat = first + 2 * names.index((campaign, dwell)) + np.arange(2)
    found: FloatArray = C[:9, seat] @ np.linalg.inv(C[np.ix_(seat, seat)]) / np.sqrt(np.diag(C)[:9, None])
    return found


def _values(tilts: Sequence[UndetectableTilt]) -> str:
    harmed = {name for each in tilts for name in each.harmed}
    axes = {what: [name.split()[-1] for name in VALUES if name in harmed and what in name] for what in KINDS}
    return "; ".join(f"{what} {', '.join(names)}" for what, names in axes.items() if names)


def _places(tilts: Sequence[UndetectableTilt]) -> str:
    largest = dict[int, float]()
    for each in tilts:
        largest[each.position] = max(each.largest, largest.get(each.position, 0.0))
    names = [f"{position_name(position)} ({_size(tilt)})" for position, tilt in sorted(largest.items())]
    return f"position{'s' if len(names) > 1 else ''} {', '.join(names)}"


def _size(tilt: float) -> str:
    return "any size" if tilt > ANY_TILT_RAD else f"up to {tilt / RAD_PER_ARCSEC:.0f} arcsec"
