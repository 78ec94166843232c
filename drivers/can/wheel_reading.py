"""A wheel's speed as a record: apart from what reads it, which takes cantools."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class WheelReading:
    """``speed`` [m/s] by a frame that came at ``host_ns`` [ns] and was handed on at ``read_ns`` [ns]."""

    host_ns: int
    speed: float
    device_ns: int | None = None
    read_ns: int = field(default=0, compare=False)

    @property
    def came_ns(self) -> int:
        """The moment [ns] from which it is there."""
        return max(self.host_ns, self.read_ns)
