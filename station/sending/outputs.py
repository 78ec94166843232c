"""Where samples can go, and what an output receives.

A line in `OUTPUTS` and a file of its own add an output.
"""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from enum import IntFlag, auto
from functools import cache
from importlib import import_module
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from drivers.addresses import host_and_port
from procedures.arrays import FloatArray, IntArray
from procedures.errors import ErrorCode
from station.errors import StationError


class Quality(IntFlag):
    """Nothing set: an untroubled sample of a valid calibration."""

    GAP_BEFORE = auto()  # something is missing between the sample before and this one
    BEGUN_ANEW = auto()  # device or port restarted: its time has no relation to what was before
    DEVICE_DOUBTS = auto()  # the device's own status says that it is not well
    SATURATED = auto()  # a count at the end of what the format can hold
    CHANNEL_CONSTANT = auto()  # a channel has put out one value for 10 s though its neighbours move
    TEMPERATURE_MISSING = auto()  # the device says none
    TEMPERATURE_OUTSIDE = auto()  # of the range that the calibration was made in
    EFFECT_LEFT_IN = auto()  # an effect of the calibration could not be subtracted
    CALIBRATION_DOUBTED = auto()  # expired, or a reference of it had expired when it was made
    NOMINAL_SCALE = auto()  # no calibration: the maker's scale factors
    UNIT_UNKNOWN = auto()  # the device does not say who it is: the calibration is taken to be its own
    TIME_BY_HOST = auto()  # the device sends no time: it is this machine's
    CLOCK_OFF = auto()  # the device's clock is off another one by more than 0.1 %
    UTC_BY_MESSAGES = auto()  # UTC is by when a receiver's messages came, to milliseconds, not by its pulse
    UNSETTLED = auto()  # effects of the calibration cannot be undone: force, rate or both are NaN


@cache
def names(flags: int) -> list[str]:
    """Return the names of the flags that are set."""
    return [str(flag.name).lower() for flag in Quality if flag & flags]


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedSamples:
    """Consecutive samples, n of them.

    ``sequence`` (n,) rises by 1 with each sample that is streamed, so that a jump is a loss on the way from here.
    ``t`` (n,) is device time [s] at the end of the sample's interval, ``utc`` (n,) [s since 1970], nan where not
    known, ``taken_ns`` (n,) when it was taken by this machine's clock [ns since 1970]. ``f`` (n, 3) is specific
    force [m/s2], ``omega`` (n, 3) angular rate [rad/s], in the axes asked for; ``temperature`` (n,) [degC] or nan.
    ``flags`` (n,) are `station.sending.outputs.Quality`, ``lost`` (n,) how many samples the device's counter
    misses before each.
    """

    sequence: IntArray
    t: FloatArray
    utc: FloatArray
    taken_ns: IntArray
    f: FloatArray
    omega: FloatArray
    temperature: FloatArray
    flags: NDArray[np.uint32]
    lost: IntArray

    def __len__(self) -> int:
        return len(self.sequence)


@dataclass(frozen=True, slots=True, eq=False)
class About:
    """What is the same of all samples: whose they are, by which calibration, in which axes.

    ``C`` (3, 3) takes the axes that are streamed to forward-right-down; ``period`` is in s.
    """

    model: str
    serial: str
    calibration: str
    axes: str
    C: FloatArray
    period: float


class BadAddress(StationError, ValueError):
    """The address of an output cannot be read; ``expected`` says what would be accepted."""

    code = ErrorCode.OUTPUT

    def __init__(self, address: str, found: str, expected: str) -> None:
        self.address, self.found, self.expected = address, found, expected
        super().__init__(f"--to {address}: found {found}, expected {expected}")


class Output(Protocol):
    """Takes samples and never waits for anybody: what does not go at once is dropped and counted.

    ``name`` is its address, ``dropped`` counts the samples that found no room, where it can be known; ``is_over``
    says that nobody can be reached any more, as when the reader of a pipe has left.
    """

    name: str

    @property
    def dropped(self) -> int | None:
        """The samples that did not go out; None of an output that cannot count them."""
        ...

    @property
    def is_over(self) -> bool:
        """Whether nobody will take anything any more."""
        ...

    def send(self, samples: CalibratedSamples) -> None:
        """Stream samples."""
        ...

    def status(self) -> str:
        """Return who listens and what was dropped, in a few words."""
        ...

    def close(self) -> None:
        """Let it go, what waits sent first where it goes at once."""
        ...


@dataclass(frozen=True, slots=True)
class OutputKind:
    """How an address begins, how all of it looks, and the module whose ``open_output(where, about)`` opens it."""

    scheme: str
    form: str
    module: str


OUTPUTS = (
    OutputKind("foxglove", "foxglove[:HOST:PORT]", "station.sending.to_foxglove"),
    OutputKind("udp", "udp:HOST:PORT", "station.sending.to_udp"),
    OutputKind("mavlink", "mavlink:udpout:HOST:PORT", "station.sending.to_mavlink"),
    OutputKind("stdout", "stdout", "station.sending.to_stdout"),
)
FORMS = ", ".join(kind.form for kind in OUTPUTS)


def kind_of(text: str) -> OutputKind:
    """Return the kind of an address; raise `BadAddress` if there is none."""
    scheme = text.partition(":")[0]
    for kind in OUTPUTS:
        if kind.scheme == scheme:
            return kind
    raise BadAddress(text, f"no output of that name ({scheme!r})", f"one of {FORMS}")


def peer_of(scheme: str, where: str, expected: str, least: int = 1) -> tuple[str, int]:
    """Return host and port of HOST:PORT; raise `BadAddress` where it is none, or the port is below ``least``."""
    if (peer := host_and_port(where, least)) is None:
        raise BadAddress(f"{scheme}:{where}", "no usable host and port", expected)
    return peer


def open_outputs(addresses: Sequence[str], about: About) -> tuple[Output, ...]:
    """Return the outputs of all addresses; nothing stays open if one is refused."""
    opened = list[Output]()
    with ExitStack() as stack:
        for text in addresses:
            where = text.partition(":")[2]
            opened.append(cast(Output, import_module(kind_of(text).module).open_output(where, about)))
            stack.callback(opened[-1].close)
        stack.pop_all()
    return tuple(opened)
