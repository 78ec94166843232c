"""Compile the attitude kernels once, at the install, rather than in front of whoever runs the first log."""

import numpy as np

from procedures.attitude.attitude import AIDS, estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.joint_filter import AID_CODE, JointFilter
from procedures.attitude.mixer import Mixer, PaperMixer
from procedures.attitude.mixer_gains import PAPER


def compile_all() -> None:
    """Run every aid over two seconds of rest, whole and a sample at a time."""
    t, still = 0.01 * np.arange(200.0), np.zeros((200, 3))
    log = AttitudeLog(np.asarray(t, np.float64), still, still - [0.0, 0.0, 9.8], still[:, 0].copy(), still.copy())
    for aid in AIDS:
        estimate(log, aid)
    estimate(log, "none", PAPER)
    steps = [JointFilter(aid).step for aid in AID_CODE]
    for step in (*steps, Mixer().step, Mixer(aid="airspeed").step, PaperMixer().step):
        step(0.0, log.rate[0], log.force[0])
        step(0.01, log.rate[1], log.force[1])
