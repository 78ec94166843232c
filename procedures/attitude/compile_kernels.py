"""Compile the kernels once, at the install, rather than in front of whoever runs the first log.

``python -m procedures.attitude.compile_kernels``.
"""

import numpy as np

from procedures.attitude.attitude_estimate import AIDS, estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.filter_choice import PAPER_GAINS
from procedures.attitude.kalman.kalman_filter import AID_CODE, AttitudeKalmanFilter


def compile_all() -> None:
    """Run every aid over two seconds of rest, whole and a sample at a time."""
    t, still = 0.01 * np.arange(200.0), np.zeros((200, 3))
    log = AttitudeLog(np.asarray(t, np.float64), still, still - [0.0, 0.0, 9.8], still[:, 0].copy(), still.copy())
    for aid in AIDS:
        estimate(log, aid)
    estimate(log, "none", PAPER_GAINS)
    for aid in AID_CODE:
        kept = AttitudeKalmanFilter(aid)
        kept.step(0.0, log.omega_b[0], log.f_b[0])
        kept.step(0.01, log.omega_b[1], log.f_b[1])


if __name__ == "__main__":
    compile_all()
