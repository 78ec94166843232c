"""The wheel of a folder or of a live run beside its window: made, and what was found by it."""

from dataclasses import replace

from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.inner.wheel_aid import WheelAid
from station.files.fusion_folder import FusionLog
from station.files.fusion_folder.wheel import mount_of
from station.locate.result import Located, WheelFound


def wheel_of(log: FusionLog) -> WheelAid | None:
    """Return what the wheel of a folder says; None where it has none."""
    if log.wheel is None or log.table.wheel is None or log.noise is None:
        return None
    return WheelAid(mount_of(log.table.wheel), log.wheel, log.noise)


def with_wheel(located: Located, window: InnerWindow) -> Located:
    """Return a result with what a window found of its wheel."""
    if (wheel := window.wheel) is None:
        return located
    found = WheelFound(1 + window.state.wheel, window.wheel_std, tuple(wheel.slips), wheel.rest_s)
    return replace(located, wheel=found)
