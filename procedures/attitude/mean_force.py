"""The specific force averaged over seconds in a frame that does not turn: gravity, or something is wrong.

In a frame that does not turn, which the rates give (Titterton and Weston, *Strapdown Inertial Navigation
Technology*, 3.5), specific force is acceleration less gravity. With Hann's weight w(t) = (1 - cos(2 pi t/T)) / T

    integral(w f_n) = -g - integral(w' v),    |integral(w' v)| <= 2 dv / T

with dv the range of the speed within T. Rates that are too large, or turn the wrong way, spread the vector and
shorten its mean; a force from which gravity was removed leaves next to nothing of it.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.frames import rotation
from procedures.units import STANDARD_GRAVITY

WINDOW_S = 10.0  # s: in it a vehicle's speed changes by less than gravity would
MIN_WINDOWS = 8  # that a short log is cut into, for their scatter; but
MIN_WINDOW_S = 1.0  # s: a hand's speed changes by some tenths of gravity in less
STEP_S = 0.02  # s that are summed before the frame is turned: no body turns by a radian in it
MAX_WINDOWS = 360  # an hour of a longer log, evenly taken
SPEED_CHANGE_STD = 10.0  # m/s in a window, 2 dv: a car's dv of 5 m/s, 1 sigma
ACCELERATION_STD = 2.0  # m/s2: what a car or a hand keeps up for seconds
ABSENT_SIGMA = 4.0
STEADY_SPREAD = 0.25  # between quartiles, of the median: a walk's is 0.2, of three random components alone 0.5
REST_S = 1.0  # s
REST_FORCE, REST_RATE = 0.03, 0.05  # of the force's length; rad/s: what stands on a table or is held still


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """A log in windows: ``turn`` (w, m, 3) [rad] and ``force`` (w, m, 3) [m/s2] of each step, ``seconds`` each."""

    turn: FloatArray
    force: FloatArray
    seconds: float

    @property
    def acceleration_std(self) -> float:
        """1 sigma [m/s2] of by how much an acceleration that lasts changes the mean force of a window."""
        return min(ACCELERATION_STD, SPEED_CHANGE_STD / self.seconds)

    def mean_length(self, reading: FloatArray | None = None) -> FloatArray:
        """Return the length (w,) [m/s2] of each window's mean force in the frame of the rates.

        ``reading`` (3, 3) is what the rates are multiplied by first. The longer one of two: with the rates, and
        with their median over the log taken for a bias, since some degrees a second are nothing in a cheap gyro.
        """
        turn = self.turn if reading is None else self.turn @ reading.T
        bias = np.median(turn.reshape(-1, 3), axis=0)
        return np.maximum(self._length(turn), self._length(turn - bias))

    def _length(self, turn: FloatArray) -> FloatArray:
        C = np.broadcast_to(np.eye(3), (len(turn), 3, 3))
        total, weight = np.zeros((len(turn), 3)), self._weight
        for i in range(turn.shape[1]):
            half = rotation(0.5 * turn[:, i])
            middle = C @ half
            total += weight[i] * np.einsum("wij,wj->wi", middle, self.force[:, i])
            C = middle @ half
        return np.asarray(np.linalg.norm(total, axis=1))

    def body_mean(self) -> FloatArray:
        """Return each window's mean force (w, 3) [m/s2] in the body's own axes."""
        return np.asarray(np.einsum("m,wmi->wi", self._weight, self.force))

    @property
    def _weight(self) -> FloatArray:
        """Hann's weights (m,) of a window's steps: what goes to and fro leaves hardly anything in the mean."""
        weight = np.hanning(self.force.shape[1] + 2)[1:-1]
        return np.asarray(weight / weight.sum())


@dataclass(frozen=True, slots=True)
class GravityCheck:
    """Lengths [m/s2] that gravity should have, medians over windows, and the 1 sigma of both by motion.

    ``level``: mean force in the frame of the rates; ``body``: in the body's axes; ``usual``: the length of the
    force itself; ``spread`` of that, relative; ``rest``: the length at rest, None where the sensor never rests.
    """

    level: float
    body: float
    std: float
    usual: float
    spread: float
    rest: float | None

    @property
    def largest(self) -> float:
        """The mean force [m/s2] in the frame, of the rates or the body, that leaves more of it."""
        return max(self.level, self.body)

    @property
    def is_absent(self) -> bool:
        """Whether less than gravity is there, whichever frame it is looked for in."""
        return STANDARD_GRAVITY - self.largest > ABSENT_SIGMA * self.std

    @property
    def is_steady(self) -> bool:
        """Whether the force has one length, as gravity has; of other forces alone it varies."""
        return self.spread < STEADY_SPREAD


def gravity_check(log: AttitudeLog, windows: Windows) -> GravityCheck:
    """Return what a log's specific force leaves as a mean over seconds, to be held against gravity."""
    length = np.linalg.norm(windows.force, axis=2)
    low, usual, high = np.percentile(length, [25, 50, 75])
    rests = rest_lengths(log)
    return GravityCheck(
        level=float(np.median(windows.mean_length())),
        body=float(np.median(np.linalg.norm(windows.body_mean(), axis=1))),
        std=windows.acceleration_std, usual=float(usual), spread=float((high - low) / max(usual, 1e-12)),
        rest=float(np.median(rests)) if len(rests) else None,
    )  # fmt: skip


def windows_of(log: AttitudeLog) -> Windows:
    """Return a log in windows of `WINDOW_S`, shorter where it is short; rows beyond the last are not used."""
    span = len(log.t) * log.nominal
    seconds = min(WINDOW_S, max(span / MIN_WINDOWS, MIN_WINDOW_S), span)
    rows = min(max(round(STEP_S / log.nominal), 1), len(log.t))
    steps = max(int(seconds / log.nominal + 1e-6) // rows, 1)
    length = rows * steps
    first = np.arange(len(log.t) // length)
    if len(first) > MAX_WINDOWS:
        first = np.linspace(0, len(first) - 1, MAX_WINDOWS).astype(int)
    at = (first[:, None] * length + np.arange(length)).reshape(-1)
    shape = (len(first), steps, rows, 3)
    intervals = np.minimum(log.intervals, 2 * log.nominal)  # what a gap hides is not known
    turn = (log.omega_b * intervals[:, None])[at].reshape(shape).sum(axis=2)
    return Windows(turn, log.f_b[at].reshape(shape).mean(axis=2), length * log.nominal)


def rest_lengths(log: AttitudeLog) -> FloatArray:
    """Return the mean length [m/s2] of the specific force in each second (n,) in which the sensor rests."""
    rows = max(round(REST_S / log.nominal), 2)
    seconds = len(log.t) // rows
    if not seconds:
        return np.zeros(0)
    force = log.f_b[: seconds * rows].reshape(seconds, rows, 3)
    rate = log.omega_b[: seconds * rows].reshape(seconds, rows, 3)
    mean = np.linalg.norm(force.mean(axis=1), axis=1)
    is_still: BoolArray = np.linalg.norm(force.std(axis=1), axis=1) < REST_FORCE * np.maximum(mean, 1e-12)
    is_still &= np.linalg.norm(rate, axis=2).max(axis=1) < REST_RATE
    return np.asarray(mean[is_still])
