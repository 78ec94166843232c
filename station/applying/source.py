"""Where samples come from: a log, a recording, a campaign; read block by block, as often as needed."""

import re
from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from procedures.arrays import FloatArray
from procedures.effects.term.inputs import AUXILIARY
from procedures.frames import TRIADS
from station.errors import DataRefused


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """A block: ``t`` (n,) [s], ``values`` (n, 6), gyroscopes and accelerometers x, y, z, nan of an absent triad.

    ``temperature`` (n,) [degC] is None where there is none; ``auxiliary`` (n,) by name. ``done`` is the share of
    the source that has been read with it. ``where`` names the file, ``lines`` each sample's line or row.
    """

    t: FloatArray
    values: FloatArray
    temperature: FloatArray | None
    auxiliary: Mapping[str, FloatArray]
    done: float
    where: str = ""
    lines: Sequence[int] = ()


@dataclass(frozen=True, slots=True)
class Stated:
    """What a source says of itself; None of what it does not say.

    ``output`` is increments, cumulative or rate; ``wrap_bits`` of cumulative counts. ``rates_in`` is a unit of
    rate or force that its columns are in; ``units`` a triad's name and the unit of its columns. ``period`` [s] is
    that of a sample; ``mounting`` along which cube axes the axes of the IMU point. ``accelerometers`` says which
    of x, y, z there are, ``damage`` what its end lacks.
    """

    name: str
    model: str | None = None
    serial: str | None = None
    output: str | None = None
    wrap_bits: int | None = None
    rates_in: str = ""
    period: float | None = None
    mounting: str | None = None
    temperature: bool = False
    auxiliary: tuple[str, ...] = ()
    triads: tuple[str, ...] = TRIADS
    accelerometers: tuple[bool, ...] = (True, True, True)
    units: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    damage: str = ""


class Source(Protocol):
    """Samples in the order of time."""

    @property
    def stated(self) -> Stated:
        """What it says of itself."""
        ...

    def blocks(self) -> Generator[Samples]:
        """Yield all samples."""
        ...


def channels_by_column(channels: Iterable[str], where: str) -> dict[str, str]:
    """Return channels by the column that each goes to; raise `DataRefused` where two would go to one."""
    found = dict[str, str]()
    for name in channels:
        plain = re.sub(r"[^A-Za-z0-9_]+", "_", name)
        column = plain if plain.startswith(AUXILIARY) else f"{AUXILIARY}{plain}"
        if column in found:
            both = f"channels {found[column]!r} and {name!r}, which both would be column {column}"
            raise DataRefused(where, None, both, "a name of letters and digits for each", "rename one")
        found[column] = name
    return found
