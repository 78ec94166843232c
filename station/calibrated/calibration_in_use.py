"""Which calibration is in use, in words."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class InUse:
    """The calibration in use, in words; ``note`` is what to know about it, such as effects left in."""

    text: str = "not known before the unit is identified"
    note: str = ""
