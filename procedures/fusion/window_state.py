"""What a visual-inertial window estimates: keyframes, where the camera sits and which way is North, as one vector.

The vector is camera (turn in c, shift in b) and heading, then of each keyframe turn in b, position, velocity, gyro
bias and accelerometer bias, then three numbers of each landmark that the prior holds on to. Turns multiply from
the right. Keyframes and landmarks stand in a level frame o of the window's own; the heading turns o onto n (P3's
rotation error of the initial world frame, IV.A). Were they in n, a window would grow ever surer of a wrong
heading: what has left was linearised at another one than what is there, and the two fit together only where
the heading is what it was. Measured on V201: 3 deg for minutes, 1 sigma 0.1.
"""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.turns import log_rotation

CAMERA = 6  # numbers of the camera
HEADING = 6  # where the heading stands
COMMON = 7  # numbers before the keyframes
FRAME = 15  # numbers of a keyframe
TURN, PLACE, SPEED, GYRO, ACCEL = (slice(3 * i, 3 * i + 3) for i in range(5))


@dataclass(frozen=True, slots=True, eq=False)
class WindowState:
    """``C_ob`` (k, 3, 3), ``p`` [m], ``v`` [m/s], ``bg`` [rad/s], ``ba`` [m/s2] (k, 3), ``C_bc`` (3, 3), ``t_bc``
    (3,) [m], ``heading`` [rad] and ``held`` (m, 3), the landmarks in the prior.
    """  # noqa: D205

    C_ob: FloatArray
    p: FloatArray
    v: FloatArray
    bg: FloatArray
    ba: FloatArray
    C_bc: FloatArray
    t_bc: FloatArray
    heading: float
    held: FloatArray

    @property
    def size(self) -> int:
        """The length of the vector."""
        return self.held_from + 3 * len(self.held)

    @property
    def held_from(self) -> int:
        """Where the landmarks begin."""
        return COMMON + FRAME * len(self.p)

    def frame(self, k: int) -> slice:
        """Return where keyframe k stands."""
        return slice(COMMON + FRAME * k, COMMON + FRAME * (k + 1))

    def moved(self, step: FloatArray) -> "WindowState":
        """Return the state after a step of the vector."""
        frames = step[COMMON : self.held_from].reshape(-1, FRAME)
        return WindowState(
            self.C_ob @ rotation(frames[:, TURN]), self.p + frames[:, PLACE], self.v + frames[:, SPEED],
            self.bg + frames[:, GYRO], self.ba + frames[:, ACCEL],
            self.C_bc @ rotation(step[:3]), self.t_bc + step[3:CAMERA], self.heading + float(step[HEADING]),
            self.held + step[self.held_from :].reshape(-1, 3),
        )  # fmt: skip

    def less(self, at: "WindowState") -> FloatArray:
        """Return the step from ``at``, a state of the same frames and landmarks or of the first of the frames."""
        k = len(at.p)
        turn = log_rotation(np.swapaxes(at.C_ob, 1, 2) @ self.C_ob[:k])
        parts = (turn, self.p[:k] - at.p, self.v[:k] - at.v, self.bg[:k] - at.bg, self.ba[:k] - at.ba)
        camera = np.r_[log_rotation(at.C_bc.T @ self.C_bc), self.t_bc - at.t_bc, self.heading - at.heading]
        return np.concatenate((camera, np.hstack(parts).ravel(), (self.held - at.held).ravel()))

    def with_frame(
        self, C_ob: FloatArray, p: FloatArray, v: FloatArray, bg: FloatArray, ba: FloatArray
    ) -> "WindowState":
        """Return the state with one more keyframe at its end."""
        return replace(
            self, C_ob=np.concatenate((self.C_ob, C_ob[None])), p=np.vstack((self.p, p)), v=np.vstack((self.v, v)),
            bg=np.vstack((self.bg, bg)), ba=np.vstack((self.ba, ba)),
        )  # fmt: skip

    def without_first(self) -> "WindowState":
        """Return the state without its oldest keyframe."""
        return replace(self, C_ob=self.C_ob[1:], p=self.p[1:], v=self.v[1:], bg=self.bg[1:], ba=self.ba[1:])


@dataclass(frozen=True, slots=True, eq=False)
class Normal:
    """Half the second derivative ``A`` (n, n) of a cost by the vector, and half its gradient ``g`` (n,)."""

    A: FloatArray
    g: FloatArray


def zero(size: int) -> Normal:
    """Return the normal equations of no cost."""
    return Normal(np.zeros((size, size)), np.zeros(size))
