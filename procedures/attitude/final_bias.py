"""The error that the mixing law settles at: You and Lee (8), the final value of (7).

For steps in all that comes in, the error of phi_m tends to that of phi_a, whatever the gains and the gyros' bias:
the integral takes the bias up, and what is wrong with the accelerometers' angle stays. That angle is wrong by what
the law leaves out of (9), and by the sensors.
"""

from dataclasses import dataclass

import numpy as np

MIN_COSINE = 0.1


@dataclass(frozen=True, slots=True)
class FinalBias:
    """By how much roll and pitch [rad] will read too much if the motion goes on as it is, and 1 sigma of it.

    Sigma is nan where the sensors' own biases are not known.
    """

    roll: float
    pitch: float
    roll_std: float
    pitch_std: float


def final_bias(
    left_out: tuple[float, float], left_std: tuple[float, float], attitude: tuple[float, float], g: float
) -> FinalBias:
    """Return the final value at an ``attitude``, roll and pitch [rad].

    Parameters
    ----------
    left_out, left_std
        Forward and right parts of the acceleration that the law does not take off, body axes, and 1 sigma of them
        with the accelerometers' biases in it [m/s2].
    g
        m/s2.
    """
    roll, pitch = attitude
    along = g * max(np.cos(pitch), MIN_COSINE)
    across = along * max(abs(np.cos(roll)), MIN_COSINE)
    return FinalBias(-left_out[1] / across, left_out[0] / along, left_std[1] / across, left_std[0] / along)
