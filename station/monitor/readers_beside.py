"""What is read beside the IMU, tick by tick: by the moments of reading, and without waiting for what lags."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from time import monotonic
from typing import TypeVar

from drivers.camera import CameraImage
from drivers.can.wheel_reading import WheelReading
from station.files.mcap_files.fix_reader import Record
from station.stream.beside import Companion, came_ns
from station.stream.stream_events import StreamState

MAX_HOLD_S = 0.1  # that a tick waits for a reader once it lags: a well one says each 0.05 s that nothing came
NoteLate = Callable[[str, Iterable[int], int], None]
T = TypeVar("T", bound=Record | CameraImage | WheelReading)


@dataclass(frozen=True, slots=True)
class Told:
    """What was told until the end of a tick."""

    records: Sequence[Record] = ()
    images: Sequence[CameraImage] = ()
    wheel: Sequence[WheelReading] = ()


@dataclass(slots=True)
class ReadersBeside:
    """Receiver, camera and wheel. ``note_late`` is told by name what counts in a later tick than it was read in.

    What a reader tells too late, a busy machine's, counts in the next tick; a replay counts it there too.
    """

    gnss: Companion[Record] | None = None
    camera: Companion[CameraImage] | None = None
    wheel: Companion[WheelReading] | None = None
    note_late: NoteLate = lambda stream, read_ns, counted_ns: None
    _until_ns: int = 0  # the end of the last tick
    _lags_since: dict[str, float] = field(default_factory=dict)  # by name, those behind now

    def advance(self) -> None:
        """Take what has come."""
        for each in self._readers.values():
            each.advance()

    def streams(self) -> tuple[StreamState, ...]:
        """Return how each does."""
        return tuple(each.stream() for each in self._readers.values())

    def have_told(self, host_ns: int) -> bool:
        """Say whether all read until a moment [ns] is here; who lags is waited for once, and not for long."""
        now = monotonic()
        behind = [name for name, each in self._readers.items() if each.up_to_ns < host_ns]
        self._lags_since = {name: self._lags_since.get(name, now) for name in behind}
        return all(now - since > MAX_HOLD_S for since in self._lags_since.values())

    def take(self, now_ns: int) -> Told:
        """Return what came since the last tick and until the end [ns] of this one."""
        until_ns = max(now_ns, self._until_ns + 1)  # a tick may seem to end before the last: a delay is learnt
        told = Told(
            self._taken("gnss", self.gnss, until_ns),
            self._taken("camera", self.camera, until_ns),
            self._taken("wheel", self.wheel, until_ns),
        )
        self._until_ns = until_ns
        return told

    def _taken(self, name: str, each: Companion[T] | None, until_ns: int) -> Sequence[T]:
        if each is None:
            return ()
        found = each.take(until_ns)
        if self._until_ns and (late := sorted({at for at in map(came_ns, found) if at <= self._until_ns})):
            self.note_late(name, late, until_ns)
        return found

    @property
    def _readers(self) -> dict[str, Companion[Record] | Companion[CameraImage] | Companion[WheelReading]]:
        named = {"gnss": self.gnss, "camera": self.camera, "wheel": self.wheel}
        return {name: each for name, each in named.items() if each is not None}
