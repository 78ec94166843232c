"""What the station knows of an IMU's output: the narrow waist everything meets in.

`CountBlock` and `RateBlock` are what a wire format decodes to; `CountSeries` and `RateSeries` are what a step of
a campaign holds: of an IMU that counts and of one that reports a rate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from procedures.arrays import FloatArray, IntArray

Samples = TypeVar("Samples", IntArray, FloatArray)


def _check(owner: object, n: int, name: str, columns: int | None) -> None:
    value = getattr(owner, name)
    expected = (n,) if columns is None else (n, columns)
    if value is not None and value.shape != expected:
        raise ValueError(f"{type(owner).__name__}.{name} has shape {value.shape}, expected {expected}")


@dataclass(frozen=True, slots=True, eq=False)
class _Block(Generic[Samples]):
    """Consecutive IMU frames as decoded.

    ``counter`` (n,) is the frame counter as sent (it wraps); where a format has none it is -1.
    ``device_time`` (n,) is the device's own time in seconds at the end of the interval, nan if it sends none.
    ``gyro`` and ``accel`` are (n, 3), raw triad axes x, y, z. ``temperature`` (n,) is in degrees Celsius, nan if
    unknown. ``status`` (n,) is the device's status word as sent and ``healthy`` (n,) whether the wire format reads
    it as good.
    """

    counter: IntArray
    device_time: FloatArray
    gyro: Samples
    accel: Samples
    temperature: FloatArray
    status: IntArray
    healthy: np.ndarray[tuple[int], np.dtype[np.bool_]]

    def __post_init__(self) -> None:
        for name in ("device_time", "temperature", "status", "healthy"):
            _check(self, len(self), name, None)
        for name in ("gyro", "accel"):
            _check(self, len(self), name, 3)

    def __len__(self) -> int:
        return len(self.counter)


class CountBlock(_Block[IntArray]):
    """Frames in device counts, before any scale factor: ``gyro`` and ``accel`` are int64 increments."""

    __slots__ = ()


class RateBlock(_Block[FloatArray]):
    """Frames of a device that sends a value per sample, float64, in the linear unit that the device is set to."""

    __slots__ = ()


SampleBlock = CountBlock | RateBlock
B = TypeVar("B", bound=SampleBlock)
BLOCK_FIELDS = _Block.__slots__


def block_rows(block: B, rows: Any) -> B:
    """Return the frames of a block that ``rows``, a slice or an index array, picks."""
    return type(block)(**{name: getattr(block, name)[rows] for name in BLOCK_FIELDS})


def joined_blocks(blocks: Sequence[B]) -> B:
    """Return at least one block, all of one kind, end to end."""
    if len(blocks) == 1:
        return blocks[0]
    columns = {name: np.concatenate([getattr(block, name) for block in blocks]) for name in BLOCK_FIELDS}
    return type(blocks[0])(**columns)


@dataclass(frozen=True, slots=True, eq=False)
class _Series(Generic[Samples]):
    """A step's output, of one or both triads.

    ``t`` (n,) seconds, end of each interval; ``gyro``, ``accel`` (n, 3) or None where the triad is
    absent; ``temperature`` (n,) degC, nan where unknown. ``starts`` (s,) holds the index of the first
    sample of each gap-free segment; ``starts[0]`` is 0. ``period`` is the measured sample period [s].
    ``extra`` holds further columns (n,): auxiliary channels ``aux_NAME`` and ``utc_s``, nan where empty.
    """

    t: FloatArray
    gyro: Samples | None
    accel: Samples | None
    temperature: FloatArray
    period: float
    starts: IntArray = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    extra: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check(self, len(self), "temperature", None)
        for name in ("gyro", "accel"):
            _check(self, len(self), name, 3)

    def __len__(self) -> int:
        return len(self.t)


class CountSeries(_Series[IntArray]):
    """A step's output in counts per sample: int64 increments."""

    __slots__ = ()


class RateSeries(_Series[FloatArray]):
    """A step's output as a value per sample, float64, in any linear unit."""

    __slots__ = ()


Series = CountSeries | RateSeries
S = TypeVar("S", bound=Series)


def block_series(blocks: Sequence[CountBlock], period: float) -> CountSeries:
    """Return gap-free blocks as the segments of a step; ``period`` [s] where they do not show it."""
    joined = joined_blocks(blocks)
    steps = np.concatenate([np.diff(block.device_time) for block in blocks])
    period = float(steps.mean()) if len(steps) else period
    starts = np.cumsum([0, *(len(block) for block in blocks[:-1])])
    return CountSeries(joined.device_time, joined.gyro, joined.accel, joined.temperature, period, starts)


def series_rows(series: S, rows: Any, starts: IntArray) -> S:
    """Return the samples that ``rows``, a slice or a mask, picks; ``starts`` (s,) is where segments begin."""
    gyro, accel = (None if values is None else values[rows] for values in (series.gyro, series.accel))
    extra = {name: values[rows] for name, values in series.extra.items()}
    return type(series)(series.t[rows], gyro, accel, series.temperature[rows], series.period, starts, extra)
