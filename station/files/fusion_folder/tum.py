"""TUM trajectories: lines ``t x y z qx qy qz qw``, seconds, metres, a unit quaternion; ``#`` begins a comment."""

from pathlib import Path

import numpy as np

from procedures.fusion.fusion_records import Trajectory
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.fusion_folder.fusion_columns import refuse_time
from station.files.opening import open_inside

TUM_COLUMNS = "t x y z qx qy qz qw"
MAX_NORM_ERROR = 1e-3  # how far a quaternion of a file may be from unit length, by rounding


def read_tum(folder: Path, name: str, line: int) -> Trajectory:
    """Read the TUM file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first line that is not eight numbers, a time that runs back, or a quaternion that is not one.
    """
    path = folder / name
    with open_inside(folder, name, folder / "fusion.toml", line) as stream:
        text = stream.read().decode("utf-8", "backslashreplace")
    rows, lines = list[list[float]](), list[int]()
    for number, content in enumerate(text.splitlines(), start=1):
        if content.strip() and not content.lstrip().startswith("#"):
            rows.append(_numbers(content, path, number))
            lines.append(number)
    if len(rows) < 2:
        raise DataRefused(path, None, f"{len(rows)} poses", f"at least two lines {TUM_COLUMNS}")
    values = np.array(rows)
    refuse_time(values[:, 0], lines, path)
    length = np.linalg.norm(values[:, 4:], axis=1)
    if len(bad := np.flatnonzero(np.abs(length - 1) > MAX_NORM_ERROR)):
        found = f"a quaternion of length {length[bad[0]]:.4g}"
        raise DataRefused(path, lines[bad[0]], found, f"{TUM_COLUMNS} with a quaternion of length 1")
    return Trajectory(values[:, 0], values[:, 1:4], values[:, 4:] / length[:, None])


def _numbers(content: str, path: Path, number: int) -> list[float]:
    try:
        values = [float(cell) for cell in content.split()]
    except ValueError:
        values = []
    if len(values) != 8 or not np.all(np.isfinite(values)):
        raise DataRefused(path, number, repr(content[:60]), f"eight numbers: {TUM_COLUMNS}")
    return values


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """Write a trajectory, there whole or what stood there before; raise `CannotWrite` if it cannot be."""
    rows = np.hstack((trajectory.t[:, None], trajectory.p, trajectory.q))
    text = "".join(f"{r[0]:.6f} " + " ".join(f"{v:.7f}" for v in r[1:]) + "\n" for r in rows.tolist())
    replace_file(path, text.encode())
