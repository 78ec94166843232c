"""What an inner window estimates: keyframes, where the camera sits and which way is North, as one vector.

The vector is camera (turn in c, shift in b), heading, the camera's time offset, what lever arm and time offset of
the antenna are off, what a wheel's scale factor is above 1, then of each keyframe turn in b, position, velocity,
gyro bias and accelerometer bias, then three numbers of each landmark that the prior holds on to. Turns multiply
from the right.

With a camera, keyframes and landmarks stand in a level frame o of the window's own; the heading turns o onto n
(Han's rotation error of the initial world frame, IV.A). Were they in n, a window would grow ever surer of a wrong
heading: what has left was linearised at another one. Without a camera they stand in n.

`Factor` is the Cholesky factor of normal equations, scaled to a unit diagonal: metres and biases differ by 1e6.
`keyframes` stand where something is measured, and often enough between.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs, dpotrf, dpotrs

from procedures.arrays import FloatArray, IntArray
from procedures.frames import rotation, rotation_vector

CAMERA = 6  # numbers of the camera
HEADING, OFFSET = 6, 7  # where the heading stands, and the camera's time offset
ANTENNA = slice(8, 12)  # where what was given of the antenna's place, and of GNSS's stamps, is off
WHEEL = 12  # where a wheel's scale factor stands
COMMON = 13  # numbers before the keyframes
SHARED = slice(HEADING, COMMON)  # what IMU and fixes share
OWN = COMMON - HEADING  # where a keyframe's numbers begin behind those
WHEEL_OWN = WHEEL - HEADING  # where the wheel's stands among those
FRAME = 15  # numbers of a keyframe
TURN, PLACE, SPEED, GYRO, ACCEL = (slice(3 * i, 3 * i + 3) for i in range(5))


@dataclass(frozen=True, slots=True, eq=False)
class WindowState:
    """``C_ob`` (k, 3, 3), ``p`` [m], ``v`` [m/s], ``bg`` [rad/s], ``ba`` [m/s2] (k, 3), ``C_bc`` (3, 3), ``t_bc``
    (3,) [m], ``heading`` [rad] and ``held`` (m, 3), the landmarks in the prior. ``offset`` [s] is to be added to
    the camera's stamps; ``rate`` (k, 3) [rad/s] are the keyframes' in b, None where the offset is given.
    ``line`` [s] is how much later a sight lower by 1 on the plane at depth 1 is taken (a rolling shutter).
    ``antenna`` (4,) is what lever arm [m], in b, and time offset [s] of the fixes are off; ``wheel`` is what a
    wheel's scale factor is above 1.
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
    offset: float = 0.0
    rate: FloatArray | None = None
    antenna: FloatArray = field(default_factory=lambda: np.zeros(4))
    wheel: float = 0.0
    line: float = 0.0

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

    def exposed(self) -> tuple[FloatArray, FloatArray]:
        """Return ``C_ob`` (k, 3, 3) and ``p`` (k, 3) [m] at the moments at which the frames were truly taken."""
        if self.rate is None:
            return self.C_ob, self.p
        return self.C_ob @ rotation(self.rate * self.offset), self.p + self.v * self.offset

    def seen_from(self, k: IntArray, down: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ``C_ob`` (m, 3, 3) and ``p`` (m, 3) [m] at the moments at which sights were truly taken.

        Parameters
        ----------
        k : (m,), the keyframe of each
        down : (m,), how far below the middle it stands, on the plane at depth 1
        """
        if self.rate is None or not self.line:  # a keyframe's sights are of one moment
            return (at := self.exposed())[0][k], at[1][k]
        late = (self.offset + self.line * down)[:, None]
        return self.C_ob[k] @ rotation(self.rate[k] * late), self.p[k] + self.v[k] * late

    def swept(self) -> tuple[FloatArray, FloatArray]:
        """Return how both move with the offset: (k, 3) [rad/s] and (k, 3) [m/s], 0 where it is given."""
        return (np.zeros_like(self.v), np.zeros_like(self.v)) if self.rate is None else (self.rate, self.v)

    def moved(self, step: FloatArray) -> "WindowState":
        """Return the state after a ``step`` (size,) of the vector."""
        frames = step[COMMON : self.held_from].reshape(-1, FRAME)
        return WindowState(
            self.C_ob @ rotation(frames[:, TURN]), self.p + frames[:, PLACE], self.v + frames[:, SPEED],
            self.bg + frames[:, GYRO], self.ba + frames[:, ACCEL],
            self.C_bc @ rotation(step[:3]), self.t_bc + step[3:CAMERA], self.heading + float(step[HEADING]),
            self.held + step[self.held_from :].reshape(-1, 3), self.offset + float(step[OFFSET]), self.rate,
            self.antenna + step[ANTENNA], self.wheel + float(step[WHEEL]), self.line,
        )  # fmt: skip

    def less(self, at: "WindowState") -> FloatArray:
        """Return the step (size,) from ``at``, a state of the same landmarks and as many frames or the first."""
        k = len(at.p)
        turn = rotation_vector(np.swapaxes(at.C_ob, 1, 2) @ self.C_ob[:k])
        parts = (turn, self.p[:k] - at.p, self.v[:k] - at.v, self.bg[:k] - at.bg, self.ba[:k] - at.ba)
        turned, moved = rotation_vector(at.C_bc.T @ self.C_bc), self.t_bc - at.t_bc
        scalars = (self.heading - at.heading, self.offset - at.offset)
        camera = (turned, moved, scalars, self.antenna - at.antenna, (self.wheel - at.wheel,))
        return np.concatenate((*camera, np.hstack(parts).ravel(), (self.held - at.held).ravel()))

    def with_frame(
        self, C_ob: FloatArray, p: FloatArray, v: FloatArray, bg: FloatArray, ba: FloatArray,
        rate: FloatArray | None = None,
    ) -> "WindowState":  # fmt: skip
        """Return the state with one more keyframe at its end.

        Parameters
        ----------
        C_ob : (3, 3), attitude
        p, v : (3,), place [m] and velocity [m/s], frame o
        bg, ba : (3,), biases [rad/s], [m/s2], body
        rate : (3,), angular rate [rad/s], body, where fixes need it
        """
        rates = None if self.rate is None or rate is None else np.vstack((self.rate, rate))
        return replace(
            self, C_ob=np.concatenate((self.C_ob, C_ob[None])), p=np.vstack((self.p, p)), v=np.vstack((self.v, v)),
            bg=np.vstack((self.bg, bg)), ba=np.vstack((self.ba, ba)), rate=rates,
        )  # fmt: skip

    def part(self, which: slice) -> "WindowState":
        """Return the state with some of its keyframes."""
        return replace(
            self, C_ob=self.C_ob[which], p=self.p[which], v=self.v[which], bg=self.bg[which], ba=self.ba[which],
            rate=None if self.rate is None else self.rate[which],
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Normal:
    """Half the second derivative ``A`` (n, n) of a cost by the vector, and half its gradient ``g`` (n,)."""

    A: FloatArray
    g: FloatArray

    def add(self, r: FloatArray, J: FloatArray, JtW: FloatArray) -> None:
        """Add weighted residuals.

        Parameters
        ----------
        r, J : (f, n) of any unit, and (f, n, m) by what is `SHARED` and by keyframes from the first f on
        JtW : (f, m, n), the Jacobians times weights
        """
        H, g = JtW @ J, (JtW @ r[..., None])[..., 0]
        f, starts = len(H), range(0, H.shape[1] - OWN, FRAME)
        self.A[SHARED, SHARED] += H[:, :OWN, :OWN].sum(axis=0)
        self.g[SHARED] += g[:, :OWN].sum(axis=0)
        own = [(slice(OWN + i, OWN + i + FRAME), slice(COMMON + i, COMMON + i + FRAME * f)) for i in starts]
        for row, here in own:
            self.g[here] += g[:, row].ravel()
            self.A[here, SHARED] += (ties := H[:, row, :OWN].reshape(-1, OWN))
            self.A[SHARED, here] += ties.T
            for column, there in own:  # einsum gives a view of the blocks on the diagonal
                np.einsum("iaib->iab", self.A[here, there].reshape(f, FRAME, f, FRAME))[:] += H[:, row, column]


def zero(size: int) -> Normal:
    """Return the normal equations of no cost."""
    return Normal(np.zeros((size, size)), np.zeros(size))


class Factor:
    """A factor of any normal equations ``A`` (n, n); raises ``LinAlgError`` where they are singular."""

    def __init__(self, A: FloatArray) -> None:
        self.size = len(A)
        self._size = 1 / np.sqrt(np.diag(A))
        self._factor = self._decomposed(A)

    def _decomposed(self, A: FloatArray) -> FloatArray:
        return _cholesky(A * self._size * self._size[:, None])

    def covariance(self, at: slice) -> FloatArray:
        """Return the covariance (k, k) of k unknowns, in their units."""
        pick = np.zeros((self.size, at.stop - at.start))
        pick[at] = np.eye(at.stop - at.start)
        return self.solve(pick)[at]

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution for right sides (n,) or (n, m)."""
        size = self._size if right.ndim == 1 else self._size[:, None]
        return size * self._solved(size * right)

    def _solved(self, right: FloatArray) -> FloatArray:
        solved: FloatArray = dpotrs(self._factor, right)[0]
        return solved


class ChainFactor(Factor):
    """A factor where a keyframe is tied to the next one and to what all have in common; no other ties are seen.

    Those ties are a band; what is common is left when the keyframes are eliminated (a Schur complement).
    """

    def _decomposed(self, A: FloatArray) -> FloatArray:
        scale, keyframes = self._size[COMMON:], A[COMMON:, COMMON:]
        band = np.zeros((2 * FRAME, len(scale)))  # LAPACK's: row d has the elements d below the diagonal
        for d in range(min(2 * FRAME, len(scale))):
            band[d, : len(scale) - d] = np.diagonal(keyframes, -d) * scale[d:] * scale[: len(scale) - d]
        factor: FloatArray
        factor, failed = dpbtrf(band, lower=1, overwrite_ab=1)
        _refuse(failed and failed + COMMON)
        common = self._size[:COMMON]
        self._ties = A[:COMMON, COMMON:] * scale * common[:, None]
        self._by_common = dpbtrs(factor, self._ties.T, lower=1)[0]
        own = A[:COMMON, :COMMON] * common * common[:, None]
        self._common = _cholesky(own - self._ties @ self._by_common)
        return factor

    def _solved(self, right: FloatArray) -> FloatArray:
        alone = dpbtrs(self._factor, right[COMMON:], lower=1)[0]
        common = dpotrs(self._common, right[:COMMON] - self._ties @ alone)[0]
        return np.concatenate((common, alone - self._by_common @ common))


def _cholesky(A: FloatArray) -> FloatArray:
    factor: FloatArray
    factor, failed = dpotrf(A.T, clean=0, overwrite_a=1)  # in columns, as LAPACK has it
    _refuse(failed)
    return factor


def _refuse(failed: int) -> None:
    if failed:
        raise np.linalg.LinAlgError(f"the normal equations are singular from unknown {failed} on")


KEYFRAME_SPACING_S = 0.05  # s between keyframes at fixes, at most
MIN_FIX_SPACING_S = 0.02  # s: a fix that follows another sooner has no keyframe


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """``t`` (n,) [s], and the index of the measurement that each one stands at, -1 where none does."""

    t: FloatArray
    at: IntArray


def keyframes(
    measured: FloatArray, first: float, last: float, spacing: float, closest: float = MIN_FIX_SPACING_S
) -> Keyframes:
    """Return keyframes from ``first`` to ``last`` [s]: at the times ``measured`` (m,) [s], and between them."""
    times, at = [first], [-1]
    for i in np.flatnonzero((measured >= first) & (measured <= last)):
        t = float(measured[i])
        if t == first:
            at[0] = int(i)
        elif t - times[-1] >= closest:
            times += [*between(times[-1], t, spacing), t]
            at += [-1] * (len(times) - len(at) - 1) + [int(i)]
    times += between(times[-1], last, spacing)
    at += [-1] * (len(times) - len(at))
    return Keyframes(np.array(times), np.array(at, np.int64))


def between(first: float, last: float, spacing: float) -> list[float]:
    """Return the times that part a span evenly, about ``spacing`` [s]: half a spacing more is no gap."""
    parts = int(np.ceil((last - first) / spacing - 0.5))
    times: list[float] = np.linspace(first, last, parts + 1)[1:-1].tolist() if parts > 1 else []
    return times


FRAME_SPACING_S = 0.1  # s between keyframes, at most
MIN_FRAME_SPACING_S = 0.09  # s: frames that follow sooner are not used


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What a camera saw at ``t`` [s]: ``feature`` (m,) at ``uv`` (m, 2) [px], the lens's distortion corrected."""

    t: float
    feature: IntArray
    uv: FloatArray


def no_frame(t: float) -> Frame:
    """Return what is seen where there is no camera."""
    return Frame(t, np.zeros(0, np.int64), np.zeros((0, 2)))


def filled(last: float, frame: Frame) -> list[Frame]:
    """Return a frame with what stands between it and the keyframe at ``last`` [s]: one each `FRAME_SPACING_S`."""
    return [*map(no_frame, between(last, frame.t, FRAME_SPACING_S)), frame]
