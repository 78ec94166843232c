"""What a wheel told, as a record: apart from what reads it, which takes cantools."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class WheelReading:
    """``speed`` [m/s] by a frame that was read at ``host_ns`` [ns]."""

    host_ns: int
    speed: float
    device_ns: int | None = None
