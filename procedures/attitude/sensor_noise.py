"""What a log shows of its sensors: noise, the gate above it, the range at which they clip, and frozen rows.

A channel whose noise exceeds its resolution does not repeat its value by chance. Where all six do so for long, and
then continue at another value, the driver or the bus held the last sample: nothing was measured there, so these
rows are a gap. A noise-free simulation and a unit at rest below its own resolution repeat themselves without
fault: there the noise is less than the resolution.
"""

import math
from dataclasses import fields, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, true_runs
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_filter import RATE_GATE
from procedures.attitude.complementary_velocity_aids import SMOOTH_S
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.strapdown_integration import GAP_RATE
from procedures.units import STANDARD_GRAVITY

MIN_FROZEN_S = 0.1  # s
MIN_REPEATS = 3  # rows: by chance once in 1e9, in three channels of noise like their resolution
MIN_NOISY_CHANNELS = 3  # channels of six
JUMP_SIGMA = 8.0  # of a channel's noise, by which it goes on elsewhere
MOVING_RATE, MOVING_FORCE = 0.05, 0.05  # rad/s; of gravity: what is no rest, where a log ends frozen
DIFFERENCES = 4  # of successive rows: no motion is left in them, white noise is
NOISE_GAIN = np.sqrt(70.0)  # of white noise in fourth differences: 1, 4, 6, 4, 1
MEDIAN_SIZE = 0.6745  # of 1 sigma
MIN_ALTERNATING = 0.6  # of fourth differences: 0.8 of white noise, next to none of motion
MIN_USED = 0.2  # of a channel's rows


def noise_above_resolution(values: FloatArray) -> float:
    """Return the standard deviation of the noise in ``values`` (n,), in their unit; nan below their resolution.

    Three equal rows in a row are not used: they may be clipped or frozen.
    """
    step = np.diff(values)
    moved = np.abs(step[step != 0.0])
    fourth = np.diff(values, DIFFERENCES)
    if not len(moved) or len(fourth) < 2:
        return float("nan")
    still = (step[1:] == 0.0) & (step[:-1] == 0.0)
    used = ~(still[:-2] | still[1:-1] | still[2:])
    if np.mean(used) < MIN_USED:
        return float("nan")
    noise = float(np.median(np.abs(fourth[used]))) / (MEDIAN_SIZE * NOISE_GAIN)
    both = used[1:] & used[:-1]
    alternating = float(np.mean((fourth[1:] * fourth[:-1] < 0.0)[both])) if both.any() else 0.0
    resolution = float(moved[moved > 1e-9 * np.abs(values).max()].min(initial=np.inf))
    return noise if alternating > MIN_ALTERNATING and noise > resolution else float("nan")


def frozen_stretches(log: AttitudeLog) -> list[slice]:
    """Return the rows in which all six channels repeat themselves, though they are noisy elsewhere."""
    values = np.hstack([log.omega_b, log.f_b])
    found = [
        slice(a, b)
        for a, b in (true_runs((values[1:] == values[:-1]).all(axis=1)) + 1).tolist()
        if b - a >= MIN_REPEATS and log.t[b - 1] - log.t[a - 1] >= MIN_FROZEN_S - 0.5 * log.nominal
    ]
    if not found:
        return []
    noise = np.array([noise_above_resolution(column) for column in values.T])
    if np.isfinite(noise).sum() < MIN_NOISY_CHANNELS:
        return []
    return [each for each in found if _goes_on_elsewhere(values, each, noise)]


def _goes_on_elsewhere(values: FloatArray, stretch: slice, noise: FloatArray) -> bool:
    held = values[stretch.start]
    if stretch.stop < len(values):
        jump = np.abs(values[stretch.stop] - held)
        return bool((jump > JUMP_SIGMA * np.where(np.isfinite(noise), noise, np.inf)).any())
    off = abs(float(np.linalg.norm(held[3:])) / STANDARD_GRAVITY - 1)
    return float(np.linalg.norm(held[:3])) > MOVING_RATE or off > MOVING_FORCE


def rows_of(log: AttitudeLog, rows: BoolArray) -> AttitudeLog:
    """Return a log of those of its rows that the boolean ``rows`` (n,) selects."""
    columns = {each.name: getattr(log, each.name) for each in fields(log)}
    return replace(log, **{name: column[rows] for name, column in columns.items() if column is not None})


def down_over_gaps(log: AttitudeLog, measured: BoolArray, down: FloatArray) -> FloatArray:
    """Return down vectors (n, 3) of all rows from those of the measured ones: in between, from one to the next."""
    filled = np.stack([np.interp(log.t, log.t[measured], down[:, i]) for i in range(3)], axis=1)
    filled[measured] = down
    length = np.linalg.norm(filled, axis=1)
    filled[length > 1e-6] /= length[length > 1e-6, None]
    return filled


def sigma_over_gaps(log: AttitudeLog, measured: BoolArray, sigma: FloatArray) -> FloatArray:
    """Return sigma (n,) [rad] of all rows from ``sigma`` (m,) of those that the boolean ``measured`` (n,) selects.

    In a gap it grows from both ends by what the rate may have been.
    """
    t, rate = log.t[measured], GAP_RATE + 0.5 * np.linalg.norm(log.omega_b[measured], axis=1)
    after = np.searchsorted(t, log.t)
    left, right = np.maximum(np.searchsorted(t, log.t, "right") - 1, 0), np.minimum(after, len(t) - 1)
    ahead = sigma[left] + rate[left] * (log.t - t[left])
    back = np.where(after < len(t), sigma[right] + rate[right] * (t[right] - log.t), np.inf)
    filled = np.minimum(ahead, back)
    filled[measured] = sigma
    return np.asarray(filled)


def frozen_rows_warning(log: AttitudeLog, stretches: list[slice]) -> str:
    """Return the line that says which rows are treated as a gap."""
    rows = sum(each.stop - each.start for each in stretches)
    start = f"{log.t[stretches[0].start]:.6g} s"
    if len(stretches) > 1:
        start += f" on, in {len(stretches)} stretches"
    return (
        f"gyroscopes and accelerometers repeat the same values for {rows} rows from {start}: "
        f"treated as {'a gap' if len(stretches) == 1 else 'gaps'}"
    )


GATE_SIGMA = 4.0
MIN_RANGE = np.radians(90.0), 15.0  # rad/s, m/s2: below, only a channel whose noise is seen is reported to clip
MIN_GYRO_NOISE = 1e-7  # rad/sqrt(s)
MIN_BIAS_WALK = 3e-6  # rad/s/sqrt(s), of a FOG's bias: three times what it does
WALK_PER_NOISE = 1.0  # 1/s
MIN_REST_FORCE_NOISE = 2e-4  # m/s/sqrt(s): a bench is never quite quiet


def gyro_noise(log: AttitudeLog) -> float:
    """Return the gyros' white noise [rad/sqrt(s)]."""
    return white_noise(log.omega_b, log.nominal)


def at_rest(settings: KalmanSettings, log: AttitudeLog) -> KalmanSettings:
    """Return the Kalman filter's settings with what this unit does at rest: its own noise, and a walk in addition.

    The walk of a bias is far less by the Allan deviation of any gyro; but a rest is never quite one.
    """
    gyro = max(gyro_noise(log), MIN_GYRO_NOISE)
    return settings._replace(
        rest_gyro_noise=gyro,
        rest_bias_walk=min(max(WALK_PER_NOISE * gyro, MIN_BIAS_WALK), settings.rest_bias_walk),
        rest_force_noise=max(white_noise(log.f_b, log.nominal), MIN_REST_FORCE_NOISE),
    )  # fmt: skip


def gate_of(noise: float) -> float:
    """Return the rate [rad/s] above which a unit of this noise [rad/sqrt(s)] turns: never below `RATE_GATE`."""
    return max(RATE_GATE, float(GATE_SIGMA * noise / np.sqrt(2 * SMOOTH_S)))


def range_limit(samples: FloatArray, least: float) -> float:
    """Return the value at which samples (n, 3), of any unit, clip; infinity where they do not.

    They clip where the largest size, above ``least`` or in a channel of more noise than
    resolution, stands for three rows running in a channel.
    """
    top = float(np.abs(samples).max(initial=0.0))
    at_top = np.abs(samples) >= top
    running = at_top[2:] & at_top[1:-1] & at_top[:-2]
    if not running.any():
        return float("inf")
    clips = running.any(axis=0)
    is_sure = top > least or any(np.isfinite(noise_above_resolution(x)) for x in samples.T[clips])
    return top if is_sure else float("inf")


def clipping_limits(log: AttitudeLog) -> tuple[float, float]:
    """Return the ranges of gyros [rad/s] and accelerometers [m/s2], infinity where unseen."""
    return range_limit(log.omega_b, MIN_RANGE[0]), range_limit(log.f_b, MIN_RANGE[1])


QUIETEST_QUANTILE = 0.05  # of the windows' variance that counts as the unit's own
# quanta^2: second differences of counts that step up and down by one, as they show as noise
COUNTING_VARIANCE = 4 / 6


def white_noise(samples: FloatArray, period: float, *, window_s: float = 1.0, quantum: float = 0.0) -> float:
    """Return the noise density of the worst axis [unit of the samples times sqrt(s)].

    From second differences, so that bias and slow motion do not count; 0 for less than a window of samples.

    Parameters
    ----------
    samples : (n, 3) float64, any unit, sensor axes
    period : s, between samples
    window_s : s, of which the quietest count; infinity takes all samples together
    quantum : what one count is, in the unit of the samples, where counting is to be subtracted
    """
    rows = max(round(window_s / period), 8) if math.isfinite(window_s) else len(samples) - 2
    windows = (len(samples) - 2) // rows if rows > 0 else 0
    if windows < 1:
        return 0.0
    second = np.diff(samples, n=2, axis=0)[: windows * rows]
    variance = np.mean(second.reshape(windows, rows, 3) ** 2, axis=1) / 6
    quiet = float(np.quantile(variance, QUIETEST_QUANTILE, axis=0).max())
    return float(np.sqrt(max(quiet - COUNTING_VARIANCE * quantum**2, 0.0) * period))
