"""Whether every dwell stands on the face that its position names, judged from raw outputs alone.

The outputs are compared with each other, never through stored parameters: an affine fit to the nominal
attitudes must leave little, and must find every sensor along its own axis. If not, the one dwell is named whose
other face mends it best.
"""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.observations import TriadDwells
from procedures.errors import FitsNoFace, WrongFace, WrongMounting
from procedures.frames import AXES, FACES, face_normal, face_of

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
