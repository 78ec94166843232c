"""When the inner layer has its keyframes: where something is measured, and often enough between."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray

KEYFRAME_SPACING_S = 0.05  # s between keyframes at fixes, at most
MIN_FIX_SPACING_S = 0.02  # s: a fix that follows another sooner has no keyframe


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """``t`` (n,) [s], and the index of the measurement that each one stands at, -1 where none does."""

    t: FloatArray
    at: IntArray


def keyframes(
    measured: FloatArray,
    first: float,
    last: float,
    spacing: float = KEYFRAME_SPACING_S,
    closest: float = MIN_FIX_SPACING_S,
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
