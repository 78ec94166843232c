"""What a wire format is: an interface document as data, with its bytes-to-block and back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.wire.frame_counters import FrameCounters
from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import SampleBlock

Frames = NDArray[np.void]  # (n,) of a format's frame dtype
Octets = bytes | memoryview
ALL_CHANNELS = frozenset({"gx", "gy", "gz", "ax", "ay", "az"})


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


class Lines(NamedTuple):
    """Frames that stand end to end, each with its trailer: as rows of their table, and (n, 2) begins and ends."""

    rows: bytes
    edges: IntArray


@dataclass(frozen=True, slots=True)
class TextForm:
    """How frames of varying size, such as lines of text, are found and read.

    ``end`` (buffer, at) returns where the frame that begins at ``at`` ends, `UNDECIDED` while more bytes could
    tell, ``at`` where it can be none. ``row`` returns a frame as one row of its kind's table; it raises ValueError
    where the frame is none after all. No frame is longer than ``longest``. ``lines``, where there is one, finds
    many intact frames of a buffer at once, each as the others would read it; what it leaves out they decide.
    """

    end: Callable[[bytes, int], int]
    row: Callable[[bytes], bytes]
    longest: int
    lines: Callable[[bytes], list[Lines]] | None = None


UNDECIDED = 2**62


@dataclass(frozen=True, slots=True)
class FrameKind:
    """One kind of frame: its table, and the constant bytes it opens with, sync and length included.

    ``channels`` are the ones that it measures (the others are 0 in its blocks); ``has_time`` says whether it sends
    a device time. ``text`` is for frames that are not their table, byte for byte.
    """

    prefix: bytes
    dtype: np.dtype[np.void]
    channels: frozenset[str] = ALL_CHANNELS
    has_time: bool = True
    text: TextForm | None = None

    @property
    def size(self) -> int:
        """Bytes in the frame, check included; in the longest one where their size varies."""
        return self.dtype.itemsize if self.text is None else self.text.longest

    @property
    def triads(self) -> frozenset[str]:
        """The triads, ``gyro`` and ``accel``, of which it measures any axis."""
        return frozenset({"gyro" if channel[0] == "g" else "accel" for channel in self.channels})

    @property
    def zeros(self) -> tuple[str, ...]:
        """The channels that are not measured though others of their triad are: they stand as 0."""
        measured = {channel[0] for channel in self.channels}
        return tuple(each for each in sorted(ALL_CHANNELS - self.channels) if each[0] in measured)


class Joiner(Protocol):
    """Makes samples of frames where one sample takes several; it remembers what is not yet whole."""

    def take(self, frames: Frames, at: IntArray) -> tuple[SampleBlock, IntArray]:
        """Return the samples that (n,) frames at (n,) places [bytes into the stream] complete.

        Next to them stands (m, 2) where the bytes that a sample needs begin and end.
        """
        ...


@dataclass(frozen=True, slots=True)
class PulseForm:
    """How a format reports a reference pulse (PPS) at its device's input, or of the seconds of reference time.

    ``age`` gives of bytes that end with a sample, a broken frame may follow, and of that sample's time [s] how
    long [s] before it the pulse came; None where they do not say. ``mark`` gives a block's frames as `encode`
    does, with such ages (n,) [s] in them.
    """

    age: Callable[[bytes, float], float | None]
    mark: Callable[[Any, FloatArray], bytes]


@dataclass(frozen=True, slots=True, eq=False)
class WireFormat:
    """A device's bytes.

    ``imu`` is the kind of frame that `encode` sends and ``example`` is one of; ``others`` are further kinds that
    hold a sample, ``passed_over`` some that hold none; ``identity`` is the kind that says who the device is, it
    may be ``imu`` itself. All kinds' prefixes are of one length; ``length_at`` is where in them the length byte
    stands, None where there is none. ``trailer`` may follow a frame, or not.

    ``is_intact`` says whether a whole frame passes its check, ``check`` describes that check and ``check_bits``
    is its width. ``max_step`` is for a weak check: a healthy value differs by no more from the last healthy one.
    ``decode`` takes (n,) frames of the ``dtype`` of any kind that holds a sample and gives a `CountBlock`, or
    where ``output`` is ``rate`` a `RateBlock`; ``encode`` gives the bytes of a block's frames and raises
    ValueError on what the format cannot hold, such as counts beyond ``count_bits``. ``carries`` names the
    block's fields that survive the trip besides gyro and accel: temperature to ``temperature_step`` [K], device
    time modulo ``time_modulus`` [s] where that is not None. ``counter_modulus`` is None where there is no frame
    counter. ``hindsight_s`` is how long after a sample came it may yet show that something was amiss with it.
    ``baud`` and ``parity`` are the usual ones, 8 data bits, 1 stop bit. ``scales`` holds the makers' nominal scale
    factors by model, where known. ``joiner`` makes the `Joiner` of a format whose samples take several frames; it
    decodes instead of ``decode``. ``pulse`` is for formats that report when a reference pulse came.
    """

    name: str
    title: str
    source: str
    length_at: int | None
    imu: FrameKind
    check: str
    check_bits: int
    is_intact: Callable[[Octets], bool]
    decode: Callable[[Frames], SampleBlock]
    encode: Callable[[Any], bytes]
    carries: frozenset[str]
    example: bytes
    baud: int
    parity: str = "N"
    output: Literal["increments", "rate"] = "increments"
    others: tuple[FrameKind, ...] = ()
    passed_over: tuple[FrameKind, ...] = ()
    trailer: bytes = b""
    count_bits: int = 32
    temperature_step: float = 0.01
    max_step: int | None = None
    counter_modulus: int | None = None
    time_modulus: float | None = None
    hindsight_s: float = 0.1
    identity: FrameKind | None = None
    identify: Callable[[bytes], Identity] | None = None
    encode_identity: Callable[[Identity], bytes] | None = None
    joiner: Callable[[FrameCounters], Joiner] | None = None
    pulse: PulseForm | None = None
    scales: Mapping[str, NominalScale] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def kinds(self) -> dict[bytes, FrameKind]:
        """The kinds of frame by their prefix."""
        identity = () if self.identity is None else (self.identity,)
        return {kind.prefix: kind for kind in (self.imu, *self.others, *self.passed_over, *identity)}

    @property
    def frame(self) -> np.dtype[np.void]:
        """The IMU frame's table in wire order, as the interface document gives it."""
        return self.imu.dtype


def fits(values: NDArray[Any], low: int, high: int, name: str) -> IntArray:
    """Return ``values`` (n,) or (n, 3) as whole numbers; raise ValueError where one is outside [low, high]."""
    ok = (values >= low) & (values <= high)
    if not ok.all():
        raise ValueError(f"{name} holds {values[~ok][0]}, expected {low} to {high}")
    whole: IntArray = values.astype(np.int64)
    return whole
