"""The station's clocks, moved by the simulation alone: nothing waits, and equal seeds see equal times."""

import datetime as real
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any, ClassVar
from unittest.mock import patch

OURS = ("station.", "drivers.", "fixtures_db.", "procedures.", "tests.year.")


class HostClock:
    """``now`` [s] is monotonic; ``ahead`` [s] is what the wall clock is ahead of it, which steps."""

    def __init__(self, utc_s: float) -> None:
        self.now, self.ahead = 1000.0, utc_s - 1000.0

    @property
    def wall(self) -> float:
        """UTC as this machine has it [s]."""
        return self.now + self.ahead


class _AsReal(type):
    """What the real classes made is an instance of these, too."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, cls.__mro__[1])


class HostDatetime(real.datetime, metaclass=_AsReal):
    """The wall clock of the simulated machine."""

    clock: ClassVar[HostClock]

    @classmethod
    def now(cls, tz: real.tzinfo | None = None) -> "HostDatetime":
        """Return the simulated machine's time."""
        return cls.fromtimestamp(cls.clock.wall, tz)


class HostDate(real.date, metaclass=_AsReal):
    """The calendar of the simulated machine."""

    @classmethod
    def today(cls) -> "HostDate":
        """Return the simulated machine's day."""
        return cls.fromtimestamp(HostDatetime.clock.wall)


def _modules() -> list[ModuleType]:
    return [module for name, module in list(sys.modules.items()) if name.startswith(OURS)]


@contextmanager
def host_clock(clock: HostClock, sleep: Any) -> Iterator[None]:
    """Let every module that is ours read ``clock``; ``sleep`` is called for `time.sleep`."""
    HostDatetime.clock = clock
    moved = [
        (module, name, new)
        for module in _modules()
        if not module.__name__.endswith(".clock")
        for name, old, new in (("datetime", real.datetime, HostDatetime), ("date", real.date, HostDate))
        if vars(module).get(name) is old
    ]
    for module, name, new in moved:
        setattr(module, name, new)
    try:
        with (
            patch.object(time, "monotonic", lambda: clock.now),
            patch.object(time, "monotonic_ns", lambda: round(clock.now * 1e9)),
            patch.object(time, "time", lambda: clock.wall),
            patch.object(time, "time_ns", lambda: round(clock.wall * 1e9)),
            patch.object(time, "sleep", sleep),
        ):
            yield
    finally:
        for module, name, _ in moved:
            setattr(module, name, getattr(real, name))
