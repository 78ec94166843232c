"""Whether every dwell stands on the face that its position names, judged from raw outputs alone.

The outputs are compared with each other, never through stored parameters: an affine fit to the nominal
attitudes must leave little, and must find every sensor along its own axis. If not, the one dwell is named whose
other face mends it best.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.errors import WrongFace, WrongMounting
from procedures.frames import AXES, FACES, face_normal, face_of
from procedures.observations import TriadDwells

LIMIT = 0.2  # g, or unit vector: far above any tilt, far below a wrong face (1 g)


def refuse_wrong_faces(seen: TriadDwells, C_ib: Sequence[FloatArray]) -> None:
    """Raise `WrongFace` or `WrongMounting` where accelerometer dwells contradict their positions.

    ``C_ib`` holds per campaign the rotation (3, 3) from the cube's axes to the IMU's. Fewer than four dwells,
    or dwells that fit any label, are let through: nothing contradicts them.
    """
    mounting = [C_ib[number] for number, _ in seen.dwells]
    faces = [face_of(dwell.position) for _, dwell in seen.dwells]
    misfit, E = _misfit(seen.rate, mounting, faces)
    if misfit < LIMIT:
        return
    if _turned(E) and _misfit(seen.rate, [E.round() @ C for C in mounting], faces)[0] < LIMIT:
        named, found = ([_axis_name(row) for row in C] for C in (mounting[0], E.round() @ mounting[0]))
        raise WrongMounting(str(named), str(found))
    trials = [
        (_misfit(seen.rate, mounting, [*faces[:i], face, *faces[i + 1 :]])[0], i, face)
        for i in range(len(faces))
        for face in FACES
        if face != faces[i]
    ]
    _, i, face = min(trials)
    dwell = seen.dwells[i][1]
    raise WrongFace(dwell.name, dwell.position, faces[i], face)


def _misfit(rate: FloatArray, mounting: Sequence[FloatArray], faces: Sequence[str]) -> tuple[float, FloatArray]:
    """Return the worst of residual [g] and cross-axis E of an affine fit to nominal attitudes, and E (3, 3).

    A sensor that hardly moves is dead, not misplaced: it is left out.
    """
    u = np.stack([C @ face_normal(face) for C, face in zip(mounting, faces, strict=True)])
    A = np.hstack((u, np.ones((len(u), 1))))
    if np.linalg.matrix_rank(A, tol=0.1) < 4:
        return 0.0, np.eye(3)
    solution, *_ = np.linalg.lstsq(A, rate, rcond=None)
    k = np.linalg.norm(solution[:3], axis=0)
    alive = k > LIMIT * k.max()
    E = np.where(alive, solution[:3] / np.where(alive, k, 1.0), np.eye(3)).T
    residual = np.abs(rate - A @ solution)[:, alive] / k[alive]
    return float(max(residual.max(), np.abs(E * ~np.eye(3, dtype=bool)).max())), E


def _turned(E: FloatArray) -> bool:
    """Say whether E is near a permutation of the axes, and not the one that it should be."""
    nearest = np.abs(E).round()
    return bool(
        np.all(nearest.sum(axis=0) == 1) and np.all(nearest.sum(axis=1) == 1) and np.any(nearest != np.eye(3))
    )


def _axis_name(row: FloatArray) -> str:
    axis = int(np.argmax(np.abs(row)))
    return ("+" if row[axis] > 0 else "-") + AXES[axis]
