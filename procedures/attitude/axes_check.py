"""Whether gyros and accelerometers speak of the same axes, in the same units.

Specific force f that is all gravity turns in the body as the body turns (Titterton and Weston 3.5), and what the
sensor accelerates by is noise about it:

    f' = f x (M omega) + noise,    M = s S,    S one of the 48 signed exchanges of axes

Both sides are averaged alike, over `BLOCK_S` and its neighbour; a constant bias of the gyros is a part of the fit.
For each S the scale s follows by least squares, with errors that are correlated from block to block (Newey and
West 1987). A turn flown with the wings' lift, or a swing, keeps f still while the rates turn: so no reading is
believed that does not also bring the mean force of seconds nearer to gravity (`mean_force.py`).
"""

import itertools
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.mean_force import Windows, windows_of
from procedures.units import RAD_PER_DEG, RAD_S_PER_DEG_H, STANDARD_GRAVITY

BLOCK_S = 0.3  # s: a hand turns to and fro more slowly, and vibration faster
MIN_BLOCKS = 10
MAX_BLOCKS = 20_000  # that are looked at: an hour and a half
LAGS = 8  # blocks over which errors are taken for correlated
SIGNIFICANT = 5.0  # sigma: 48 readings are tried
MIN_EXPLAINED = 0.3  # of the change of f, by rates of a scale that a unit has
MIN_EXPLAINED_ELSE = 0.65  # by rates of other axes, or of a scale that no unit has
TIE_RATIO = 1.5  # times the least residual: readings that are indistinguishable; the fewest changes are named
# a factor: beyond, it is reported; a long lever arm makes 1.9 of 1, so that what it may be is not refused
MIN_SCALE_ERROR = 1.5
NEAR_UNIT = 0.25  # relative: how near to a unit's factor a scale is taken for it; a lever arm makes 0.83 of 1
MIN_GAIN = 3e-4  # of gravity, in the mean force: what two readings that agree may differ by
GAIN_SIGMA = 3.0
TURNING_WINDOWS = 25.0  # per cent of a log's windows: a vehicle turns in as many
MIN_MISSING = 0.1  # of gravity: what gyros that clip or lose samples may lose of it
TOO_LARGE = {"deg/s": RAD_PER_DEG, "mrad/s": 1e-3, "mdeg/s": 1e-3 * RAD_PER_DEG}  # rad/s
RANGE_FACTORS = (4.0, 8.0)  # of full-scale ranges; 2 is what a lever arm may make of 1
RATE_LETTERS = "pqr"
ARM_ITERATIONS = 4  # of the lever arm: the force of 25 m at 0.2 Hz is four times gravity's change


@dataclass(frozen=True, slots=True)
class AxesDisagreement:
    """What the rates seem to be.

    ``reading`` such as "p,-q,r"; ``units`` such as ("deg/s",), several where a scale is that of several, none
    where it is of none; ``scale`` by which to multiply, and its 1 sigma, None of a unit's own factor; ``row`` at
    which it is clear. ``is_by_lever_arm`` is whether a lever arm of any length may explain the scale.
    """

    reading: str
    units: tuple[str, ...]
    scale: float
    scale_std: float | None
    row: int
    is_by_lever_arm: bool = False

    @property
    def has_other_axes(self) -> bool:
        """Whether signs or the order of axes are wrong, not the unit alone."""
        return self.reading != "p,q,r"


@dataclass(frozen=True, slots=True, eq=False)
class RateScale:
    """How many times as fast as rates read by ``S`` gravity turns, 1 sigma, and the share explained."""

    S: FloatArray
    scale: float
    std: float
    explained: float


def units_of_scale(scale: float, period_s: float) -> tuple[str, ...]:
    """Return what columns of rad/s hold whose rates must be multiplied by ``scale``; ("rad/s",) of 1."""
    increment = 1 / period_s
    known = {
        "rad/s": 1.0, **TOO_LARGE, "deg/h": RAD_S_PER_DEG_H,
        "rad/s converted from deg/s once too often": 1 / RAD_PER_DEG,
        **{f"rates of a range {factor:g} times as large": factor for factor in RANGE_FACTORS},
        "increments of angle in rad": increment, "increments of angle in deg": RAD_PER_DEG * increment,
    }  # fmt: skip
    return tuple(name for name, factor in known.items() if is_near(scale, factor))


def is_near(scale: float, factor: float) -> bool:
    """Say whether a scale that motion shows is that of a unit."""
    return abs(scale / factor - 1) < NEAR_UNIT


def disagreement(log: AttitudeLog, windows: Windows | None = None) -> AxesDisagreement | None:
    """Return how gyros and accelerometers disagree, None where they agree or the log cannot show it."""
    scales, windows = rate_scales(log), windows or windows_of(log)
    return (_by_change(log, scales, windows) or _by_mean(log, windows)) if scales else None


def _by_change(log: AttitudeLog, scales: list[RateScale], windows: Windows) -> AxesDisagreement | None:
    """Return the reading by which the rates explain how the force changes."""
    sure = [each for each in scales if each.scale > SIGNIFICANT * each.std]  # of the two signs of each S, one
    if not sure:
        return None
    least = min(1 - each.explained for each in sure)
    near = [each for each in sure if 1 - each.explained < TIE_RATIO * least + 1e-9]
    found = max(near, key=lambda each: (float(np.trace(each.S)), each.explained))
    units = units_of_scale(found.scale, log.nominal)
    other_axes = found is not scales[0]  # the axes as given
    off = abs(np.log(max(found.scale, 1e-300))) > np.log(MIN_SCALE_ERROR)
    if not other_axes and (not off or abs(found.scale - 1) < SIGNIFICANT * found.std):
        return None
    if found.explained < (MIN_EXPLAINED if units and not other_axes else MIN_EXPLAINED_ELSE):
        return None
    if not _is_nearer_gravity((found.scale if off else 1.0) * found.S, windows):
        return None
    return AxesDisagreement(
        _named(found.S), units if off else ("rad/s",), found.scale, found.std, _row(log),
        is_by_lever_arm=not other_axes and _may_be_lever_arm(log),
    )  # fmt: skip


def _by_mean(log: AttitudeLog, windows: Windows) -> AxesDisagreement | None:
    """Return the largest unit in which the rates leave gravity's mean over seconds whole: a vehicle turns so."""

    def least(reading: FloatArray | None) -> float:
        return float(np.percentile(windows.mean_length(reading), TURNING_WINDOWS))

    std = windows.acceleration_std / np.sqrt(len(windows.turn))
    if STANDARD_GRAVITY - least(None) < max(SIGNIFICANT * std, MIN_MISSING * STANDARD_GRAVITY):
        return None
    for unit, factor in TOO_LARGE.items():
        whole = least(factor * np.eye(3))
        if abs(whole / STANDARD_GRAVITY - 1) < MIN_MISSING and _is_nearer_gravity(factor * np.eye(3), windows):
            return AxesDisagreement("p,q,r", (unit,), factor, None, _row(log))
    return None


def rate_scales(log: AttitudeLog) -> list[RateScale]:
    """Return the scale of the rates in each of 48 readings, the axes as given first; none of a short log."""
    rows = max(round(BLOCK_S / log.nominal), 1)
    blocks = min(len(log.t) // rows, MAX_BLOCKS)
    if blocks < MIN_BLOCKS:
        return []
    y, x, bias = _regression(log, rows, blocks)
    y, x = _without(bias, y), _without(bias, x)
    return [_fitted(S, x @ S.reshape(-1), y) for S in _signed_permutations()]


def _without(columns: FloatArray, values: FloatArray) -> FloatArray:
    """Return ``values`` (3n, ...) [m/s2] less what ``columns`` (3n, k) explain of them."""
    Q = np.linalg.qr(columns + 1e-12)[0]
    return np.asarray(values - Q @ (Q.T @ values))


def _fitted(S: FloatArray, turned: FloatArray, y: FloatArray) -> RateScale:
    """Return the scale of rates read by ``S`` that turn the force by ``turned`` (3n,), where ``y`` did [m/s2]."""
    total = max(float(y @ y), 1e-300)
    size = max(float(turned @ turned), 1e-300)
    scale = float(turned @ y) / size
    error = y - scale * turned
    score = (turned * error).reshape(-1, 3).sum(axis=1)
    lagged = [
        (2 - (k == 0)) * (1 - k / (LAGS + 1)) * (score[k:] @ score[: len(score) - k]) for k in range(LAGS + 1)
    ]
    white = float(error @ error) / (len(y) - 12) * size  # less than that only where few blocks turn
    std = float(np.sqrt(max(float(sum(lagged)), white))) / size
    return RateScale(S, scale, std, 1 - float(error @ error) / total)


def _may_be_lever_arm(log: AttitudeLog) -> bool:
    """Say whether rates as given may be right, the sensor being away from the centre of its motion by any arm r.

    Then ``w' x r + w x (w x r)`` adds to gravity's specific force. Of a swing of one frequency it looks like
    another scale, of several frequencies or about all axes it does not.
    """
    rows = max(round(BLOCK_S / log.nominal), 1)
    blocks = min(len(log.t) // rows, MAX_BLOCKS)
    used = rows * blocks
    t, rate = log.t[:used], log.omega_b[:used]
    rise = np.gradient(rate, t, axis=0)
    forces = np.stack([np.cross(rise, arm) + np.cross(rate, np.cross(rate, arm)) for arm in np.eye(3)], axis=2)
    of_arm = np.diff(forces.reshape(blocks, rows, 3, 3).mean(axis=1), axis=0).reshape(-1, 3)
    r = np.zeros(3)
    for _ in range(ARM_ITERATIONS):  # gravity alone turns with the body: what the arm adds is subtracted first
        y, x, bias = _regression(AttitudeLog(t, rate, log.f_b[:used] - forces @ r), rows, blocks)
        turned, others = x @ np.eye(3).reshape(-1), np.column_stack((of_arm, bias))
        r = r + np.linalg.lstsq(np.column_stack((turned, others)), y, rcond=None)[0][1:4]
        found = _fitted(np.eye(3), _without(others, turned), _without(others, y))
    low, high = (found.scale + sign * SIGNIFICANT * found.std for sign in (-1, 1))
    return low < MIN_SCALE_ERROR and high > 1 / MIN_SCALE_ERROR


def _regression(log: AttitudeLog, rows: int, blocks: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return y (3n,) [m/s2], x (3n, 9) for M row by row, and (3n, 3) for a bias of the rates.

    y is the difference of two neighbouring blocks' mean force: the integral of f' under a triangle, as are x.
    """
    used = rows * blocks
    force = log.f_b[:used]
    intervals = np.minimum(log.intervals[:used], 2 * log.nominal)
    rate = log.omega_b[:used] * intervals[:, None]
    rises = (np.arange(rows) + 0.5) / rows
    across = np.stack([np.cross(force, axis) for axis in np.eye(3)], axis=2)  # (used, 3, 3): f x e_i

    def under_triangle(part: FloatArray) -> FloatArray:
        in_blocks = part.reshape(blocks, rows, -1)
        up, down = np.einsum("r,brk->bk", rises, in_blocks), np.einsum("r,brk->bk", rises[::-1], in_blocks)
        return np.asarray(up[:-1] + down[1:])

    y = np.diff(force.reshape(blocks, rows, 3).mean(axis=1), axis=0).reshape(-1)
    x = np.stack([under_triangle(across[:, :, i] * rate[:, j, None]) for i in range(3) for j in range(3)], axis=2)
    bias = np.stack([under_triangle(across[:, :, i] * intervals[:, None]) for i in range(3)], axis=2)
    return y, x.reshape(-1, 9), bias.reshape(-1, 3)


def _is_nearer_gravity(reading: FloatArray, windows: Windows) -> bool:
    """Say whether rates so read leave more of gravity in the mean force of seconds than as given, surely.

    The gain is held against the scatter of what they leave from window to window, which is the motion's.
    """
    left = windows.mean_length(reading)
    if not len(left):
        return False
    gain = float(np.mean(left - windows.mean_length()))
    std = float(left.std(ddof=1) / np.sqrt(len(left))) if len(left) > 1 else windows.acceleration_std
    return gain > max(GAIN_SIGMA * std, MIN_GAIN * STANDARD_GRAVITY)


def _row(log: AttitudeLog) -> int:
    """Return the row at which the rates as given have turned the body by a radian."""
    turned = np.cumsum(np.linalg.norm(log.omega_b, axis=1) * log.intervals)
    return min(int(np.searchsorted(turned, 1.0)), len(turned) - 1)


def _signed_permutations() -> list[FloatArray]:
    """Return the 48 variants to read three axes, the axes as they are first."""
    return [
        np.diag(signs) @ np.eye(3)[list(order)]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]


def unit_by_motion(log: AttitudeLog) -> str | None:
    """Return the unit of rates read as rad/s, "rad/s" or "deg/s"; None where the motion does not show it."""
    windows = windows_of(log)
    if (seen := disagreement(log, windows)) is not None:
        return seen.units[0] if not seen.has_other_axes and seen.units == ("deg/s",) else None
    if not (scales := rate_scales(log)):
        return None
    given = scales[0]
    is_clear = given.explained > MIN_EXPLAINED and given.scale > SIGNIFICANT * given.std
    return "rad/s" if is_clear and abs(np.log(given.scale)) < np.log(MIN_SCALE_ERROR) else None


def _named(S: FloatArray) -> str:
    return ",".join(("-" if row.min() < 0 else "") + RATE_LETTERS[int(np.argmax(np.abs(row)))] for row in S)
