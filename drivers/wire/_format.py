"""What a wire format is: an interface document as data, with its bytes-to-`CountBlock` and back.

One file per format defines one `WireFormat`; the family tests hold every one to the same contract.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import IntArray
from procedures.records import CountBlock

Frames = NDArray[np.void]  # (n,) of a format's frame dtype
Octets = bytes | memoryview


@dataclass(frozen=True, slots=True)
class Identity:
    """What a device says it is: empty string where it does not say; ``period`` [s] is 0 where unstated."""

    model: str = ""
    serial: str = ""
    period: float = 0.0


@dataclass(frozen=True, slots=True)
class NominalScale:
    """A maker's scale factor: one count is ``gyro`` radians and ``accel`` metres per second.

    Counts are increments per sample; ``rate_hz`` is the maker's sample rate, to be compared with the measured one.
    """

    model: str
    gyro: float
    accel: float
    rate_hz: float
    source: str


@dataclass(frozen=True, slots=True)
class FrameKind:
    """One kind of frame: its table, and the constant bytes it opens with, sync and length included."""

    prefix: bytes
    dtype: np.dtype[np.void]

    @property
    def size(self) -> int:
        """Bytes in the frame, check included."""
        return self.dtype.itemsize


class JoinCounters(Protocol):
    """What a `Joiner` counts: see `drivers.framing.FrameCounters`."""

    bad_crc: int
    bad_length: int
    foreign: int
    incomplete: int
    late: int
    bus_errors: int


class Joiner(Protocol):
    """Makes samples of frames where one sample takes several; it remembers what is not yet whole."""

    def take(self, frames: Frames, at: IntArray) -> tuple[CountBlock, IntArray]:
        """Return the samples that (n,) frames at (n,) places [bytes into the stream] complete.

        Beside them stands (m, 2) where the bytes that a sample needs begin and end.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class WireFormat:
    """A device's bytes.

    ``is_intact`` says whether a whole frame passes its check, ``check`` describes that check and
    ``check_bits`` is its width. ``length_at`` is where in the prefix the length byte stands.
    ``decode`` takes (n,) frames of ``imu.dtype``; ``encode`` gives the bytes of a block's frames and raises
    ValueError on what the format cannot hold. ``carries`` names the `CountBlock` fields that survive the
    trip besides ``gyro`` and ``accel``. ``counter_modulus`` is None where there is no frame counter.
    ``identity`` is the kind of frame that says who the device is; it may be ``imu`` itself.
    ``joiner`` makes the `Joiner` of a format whose samples take several frames; it decodes instead of ``decode``.
    ``baud`` is the usual one, 8N1. ``scales`` holds the makers' nominal scale factors by model, where known.
    """

    name: str
    title: str
    source: str
    sync: bytes
    length_at: int
    imu: FrameKind
    check: str
    check_bits: int
    is_intact: Callable[[Octets], bool]
    decode: Callable[[Frames], CountBlock]
    encode: Callable[[CountBlock], bytes]
    carries: frozenset[str]
    example: bytes
    baud: int
    counter_modulus: int | None = None
    identity: FrameKind | None = None
    identify: Callable[[bytes], Identity] | None = None
    encode_identity: Callable[[Identity], bytes] | None = None
    joiner: Callable[[JoinCounters], Joiner] | None = None
    scales: Mapping[str, NominalScale] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def kinds(self) -> dict[bytes, FrameKind]:
        """The kinds of frame by their prefix."""
        kinds = (self.imu,) if self.identity is None else (self.imu, self.identity)
        return {kind.prefix: kind for kind in kinds}

    @property
    def frame(self) -> np.dtype[np.void]:
        """The IMU frame's table in wire order, as the interface document gives it."""
        return self.imu.dtype


def fits(values: NDArray[Any], low: int, high: int, name: str) -> IntArray:
    """Return ``values`` as int64; raise ValueError where one is outside [low, high] or not a whole number."""
    ok = (values >= low) & (values <= high)
    if not ok.all():
        raise ValueError(f"{name} holds {values[~ok][0]}, expected {low} to {high}")
    whole: IntArray = values.astype(np.int64)
    return whole


def seal(frames: Frames, crc: Callable[[Octets], int]) -> bytes:
    """Return the bytes of ``frames``, the last field ``crc`` computed over all that stands before it."""
    size, view = frames.dtype.itemsize, memoryview(frames.tobytes())
    end = frames.dtype.fields["crc"][1] if frames.dtype.fields else size
    frames["crc"] = [crc(view[at : at + end]) for at in range(0, len(view), size)]
    return frames.tobytes()
