"""What the station knows of an IMU's output: the narrow waist everything meets in.

`CountBlock` and `RateBlock` are what a wire format decodes to; `CountSeries` and `RateSeries` are what a step of
a campaign holds: of an IMU that counts and of one that reports a rate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from procedures.arrays import FloatArray, IntArray


def _check(owner: object, n: int, name: str, columns: int | None) -> None:
    value = getattr(owner, name)
    expected = (n,) if columns is None else (n, columns)
    if value is not None and value.shape != expected:
        raise ValueError(f"{type(owner).__name__}.{name} has shape {value.shape}, expected {expected}")


def _check_block(block: "SampleBlock") -> None:
    n = len(block.counter)
    for name in ("device_time", "temperature", "status", "healthy"):
        _check(block, n, name, None)
    for name in ("gyro", "accel"):
        _check(block, n, name, 3)


def _check_series(series: "Series") -> None:
    _check(series, len(series.t), "temperature", None)
    for name in ("gyro", "accel"):
        _check(series, len(series.t), name, 3)


@dataclass(frozen=True, slots=True, eq=False)
class CountBlock:
    """Consecutive IMU frames in device counts, as decoded, before any scale factor.

    ``counter`` (n,) is the frame counter as sent (it wraps); where a format has none it is -1.
    ``device_time`` (n,) is the device's own time in seconds at the end of the interval, nan if it sends none.
    ``gyro`` and ``accel`` are (n, 3) increments, raw triad axes x, y, z. ``temperature`` (n,) is in
    degrees Celsius, nan if unknown. ``status`` (n,) is the device's status word as sent and
    ``healthy`` (n,) whether the wire format reads it as good.
    """

    counter: IntArray
    device_time: FloatArray
    gyro: IntArray
    accel: IntArray
    temperature: FloatArray
    status: IntArray
    healthy: np.ndarray[tuple[int], np.dtype[np.bool_]]

    def __post_init__(self) -> None:
        _check_block(self)

    def __len__(self) -> int:
        return len(self.counter)


@dataclass(frozen=True, slots=True, eq=False)
class RateBlock:
    """Consecutive IMU frames of a device that sends a value per sample; fields as in `CountBlock`, but float64.

    ``gyro`` and ``accel`` (n, 3) are in the linear unit that the device is set to.
    """

    counter: IntArray
    device_time: FloatArray
    gyro: FloatArray
    accel: FloatArray
    temperature: FloatArray
    status: IntArray
    healthy: np.ndarray[tuple[int], np.dtype[np.bool_]]

    def __post_init__(self) -> None:
        _check_block(self)

    def __len__(self) -> int:
        return len(self.counter)


SampleBlock = CountBlock | RateBlock
B = TypeVar("B", bound=SampleBlock)
BLOCK_FIELDS = CountBlock.__slots__


def block_rows(block: B, rows: Any) -> B:
    """Return the frames of a block that ``rows``, a slice or an index array, picks."""
    return type(block)(**{name: getattr(block, name)[rows] for name in BLOCK_FIELDS})


def joined_blocks(blocks: Sequence[B]) -> B:
    """Return at least one block, all of one kind, end to end."""
    if len(blocks) == 1:
        return blocks[0]
    columns = {name: np.concatenate([getattr(block, name) for block in blocks]) for name in BLOCK_FIELDS}
    return type(blocks[0])(**columns)


def _one_segment() -> IntArray:
    return np.zeros(1, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class CountSeries:
    """A step's output in counts per sample (increments), of one or both triads.

    ``t`` (n,) seconds, end of each interval; ``gyro``, ``accel`` (n, 3) int64 or None where the triad is
    absent; ``temperature`` (n,) degC, nan where unknown. ``starts`` (s,) holds the index of the first
    sample of each gap-free segment; ``starts[0]`` is 0. ``period`` is the measured sample period [s].
    ``extra`` holds further columns (n,): auxiliary channels ``aux_NAME`` and ``utc_s``, nan where empty.
    """

    t: FloatArray
    gyro: IntArray | None
    accel: IntArray | None
    temperature: FloatArray
    period: float
    starts: IntArray = field(default_factory=_one_segment)
    extra: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_series(self)

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True, slots=True, eq=False)
class RateSeries:
    """A step's output as a value per sample in any linear unit; fields as in `CountSeries`, but float64."""

    t: FloatArray
    gyro: FloatArray | None
    accel: FloatArray | None
    temperature: FloatArray
    period: float
    starts: IntArray = field(default_factory=_one_segment)
    extra: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_series(self)

    def __len__(self) -> int:
        return len(self.t)


Series = CountSeries | RateSeries
S = TypeVar("S", bound=Series)


def block_series(blocks: Sequence[CountBlock], period: float) -> CountSeries:
    """Return gap-free blocks as the segments of a step; ``period`` [s] where they do not tell."""
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
