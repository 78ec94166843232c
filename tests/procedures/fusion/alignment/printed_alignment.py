"""Han's eq. 3 as printed, for comparison: attitude from GNSS velocity differentiated.

Han 2022 (III.B) takes roll and pitch from ``C a_i = G + a_l``: the accelerometer against gravity and the
acceleration of the motion, GNSS velocity differentiated, and yaw from the track. Without a camera both come from
the same equation, carried to one body frame by the gyro and solved for all instants at once (Wahba's problem).
Differencing turns white velocity noise into ``sqrt(2) std / dt`` of acceleration, and no bias is estimated;
`MovingAligner` is what the station uses. Measured beside it in docs/how-to/locate.md.
"""

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.preintegration import grid, integrate


def align_as_printed(imu: ImuSeries, fixes: GnssFixes, gravity: float, gyro_bias: FloatArray) -> FloatArray:
    """Return C_nb (3, 3) at the last fix; every fix has a velocity and lies within the IMU's data."""
    g = grid(imu, fixes.t)
    turned = integrate(g, gyro_bias, np.zeros(3)).C[g.at]
    a_n = np.gradient(fixes.v_n, fixes.t, axis=0) + np.array([0.0, 0.0, gravity])
    f_b = interpolated(fixes.t, imu.t, imu.f_b)
    felt = np.einsum("nij,nj->ni", turned, f_b)
    U, _, Vt = np.linalg.svd(a_n.T @ felt)
    C: FloatArray = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt @ turned[-1]
    return C
