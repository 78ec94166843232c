"""Does a recording move and rest? Then it is a sequence, else a soak."""

import numpy as np

from procedures.counts.sample_records import Series
from procedures.rests_and_moves.rest_detection import scatter_level

MOVED_LEVEL = 30.0  # times the variance of the quietest windows: no noise that is merely uneven
TURNED = 0.1  # of 1 g: 6 deg of the vertical
# Where 1 g is not known a move must change the output by more than rests change, and than samples scatter
TIMES_DRIFT, TIMES_NOISE = 20.0, 20.0
# Of a scale factor that was calibrated once: a gyroscope that turned farther from whole turns turned by another
# angle, or is not calibrated, and nothing in the recording tells which
MAX_SCALE_ERROR = 0.005


def moves_and_rests(series: Series, outputs_per_g: float | None = None) -> bool:
    """Say whether the accelerometers rest in two attitudes at least and move in between.

    ``outputs_per_g`` is their nominal scale factor, where it is known.
    """
    if series.accel is None:
        return False
    samples = np.asarray(series.accel, dtype=np.float64)
    rests = scatter_level(series).rests(MOVED_LEVEL)
    if len(rests) < 2:
        return False
    means = np.array([samples[rest].mean(axis=0) for rest in rests])
    apart = np.linalg.norm(np.diff(means, axis=0), axis=1)
    if outputs_per_g is not None:
        return bool(np.max(apart) > TURNED * outputs_per_g)
    halves = [np.array_split(samples[rest], 2) for rest in rests]
    drift = float(np.median([np.linalg.norm(b.mean(axis=0) - a.mean(axis=0)) for a, b in halves]))
    noise = float(np.median([np.linalg.norm(samples[rest].std(axis=0)) for rest in rests]))
    return bool(np.max(apart) > max(TIMES_DRIFT * drift, TIMES_NOISE * noise))


def turned_deg(series: Series, axis: int, outputs_per_deg_s: float) -> float:
    """Return by how many degrees a series turned about sensor ``axis``, above the rate at both its ends."""
    if series.gyro is None:
        return 0.0
    rate = np.asarray(series.gyro[:, axis], dtype=np.float64)
    end = max(len(rate) // 20, 1)
    rest = np.median(np.concatenate((rate[:end], rate[-end:])))
    return float(np.sum(rate - rest)) * series.period / outputs_per_deg_s


def true_angle(
    turned_deg: float, beyond_deg: float = 0.0, scale_error: float = MAX_SCALE_ERROR, slack_deg: float = 0.0
) -> float | None:
    """Return the angle ``beyond_deg`` + 360 n that a gyroscope turned by; None where no n fits, or more than one.

    An angle fits where the gyroscope is within ``scale_error`` of it, relative, or within ``slack_deg`` [deg].
    From 1 / (2 ``scale_error``) turns on some n always fits, from 1 / ``scale_error`` on always more than one.
    """
    if not np.isfinite(turned_deg):
        return None
    turned, sign = abs(turned_deg), -1 if turned_deg < 0 else 1
    low = min(turned / (1 + scale_error), turned - slack_deg)
    high = max(turned / (1 - scale_error), turned + slack_deg)
    first, last = np.ceil((low - sign * beyond_deg) / 360), np.floor((high - sign * beyond_deg) / 360)
    return float(beyond_deg + sign * 360 * first) if first == last else None


def whole_turns(turned_deg: float) -> int | None:
    """Return the whole revolutions that an angle by a gyroscope is; None where it is not surely that many."""
    angle = true_angle(turned_deg)
    return round(abs(angle) / 360) if angle else None
