"""A simulated unit's truth by the names of a solution's parameters, in the units of files."""

import numpy as np

from drivers.simulated.bench_truth import imu_from_cube
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.dwells_and_turns.bench_parameters import mean_cube
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S


def truth_values(truth: Truth, *, is_certified: bool = False) -> dict[str, float]:
    """Return the truth keyed as `procedures.calibration.solution.Solution.names`.

    Misalignment and scale factor refer to the mean cube, as the solution's do: columns of ``k E`` along the mean
    normals of the face pairs instead of the cube's own axes, to which those of a certified cube refer.
    """
    up, down = truth.faces_rad[::2], truth.faces_rad[1::2]  # (3, 2) each, by face pair
    C_sb = imu_from_cube(truth.imu_axes)
    mean = np.eye(3) if is_certified else C_sb @ mean_cube((up - down) / 2) @ C_sb.T
    values = {
        **_triad("accelerometer", truth.accel_k, truth.accel_e @ mean, truth.accel_d_g),
        **_triad("gyroscope", truth.gyro_k, truth.gyro_e @ mean, truth.gyro_d_deg_s * DEG_H_PER_DEG_S),
        "slab.tilt.east": float(truth.slab_tilt_rad[0]),
        "slab.tilt.north": float(truth.slab_tilt_rad[1]),
    }
    for i, pair in enumerate(AXES):
        for j, other in enumerate(axis for axis in AXES if axis != pair):
            values[f"fixture.parallelism.{pair}.{other}"] = float(up[i, j] + down[i, j])
    return values


def _triad(name: str, k: FloatArray, E: FloatArray, D: FloatArray) -> dict[str, float]:
    length = np.linalg.norm(E, axis=1)
    values = {}
    for q, sensor in enumerate(AXES):
        values[f"{name}.scale_factor.{sensor}"] = float(k[q] * length[q])
        values[f"{name}.bias.{sensor}"] = float(D[q] / length[q])
        for p, body in enumerate(AXES):
            values[f"{name}.misalignment.{sensor}{body}"] = float(E[q, p] / length[q])
    return values
