"""`effect/1`: an effect that no catalogue holds, as a file of TOML (docs/how-to/own-effects.md)."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.term.effect_of_term import MAX_PARAMETERS, MAX_TERMS, TermEffect
from procedures.effects.term.law import Parameter
from procedures.effects.term.units import parse_unit
from procedures.errors import TermRefused
from station.errors import DataRefused
from station.files.toml_file import (
    Key,
    Sha256,
    TomlTable,
    line_of,
    line_of_keys,
    matching,
    read_tables,
    read_text_file,
)

if TYPE_CHECKING:
    from sqlalchemy.orm import Session
from station.errors import Altered

FORMAT = "effect/1"
MAX_BYTES = 2**16
MAX_SHOWN = 80  # characters of a term in a message
Positive = Annotated[float, Field(gt=0, le=1e12)]
Word = Annotated[str, matching(r"[A-Za-z]\w{0,39}", "a letter, then at most 39 letters, digits and _")]
Text = Annotated[str, matching(r"[^\x00-\x1f\x7f]{1,300}", "1 to 300 characters on one line")]
DIGITS = 12
Digits = Annotated[str, matching(rf"[0-9a-f]{{{DIGITS}}}", f"{DIGITS} hexadecimal digits")]


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


class ParameterTable(TomlTable):
    """An entry of ``[shape]``: a parameter of the term is fitted between ``low`` and ``high``, in ``unit``."""

    unit: str
    low: Positive
    high: Positive


class OriginTable(TomlTable):
    """``[origin]``: the campaigns, day and diagnosis/2 that an effect was adopted from.

    ``data`` are the first `DIGITS` digits of the hash of every recording in them, whatever its folder is called.
    ``confidence`` is of one that a search found: proposed, until other campaigns, ``confirmed_by``, showed it.
    """

    campaigns: list[Text]
    date: Text
    diagnosis_sha256: Sha256
    data: list[Digits] = []
    confidence: Literal["proposed", "confirmed"] | None = None
    confirmed_by: list[Text] = []


class EffectTable(TomlTable):
    """The whole of an `effect/1`; ``unit`` is that of a coefficient, ``plausible`` 1 sigma of it."""

    format: Literal["effect/1"]
    name: Word
    triad: Literal["accelerometer", "gyroscope"]
    term: Annotated[list[str], Field(min_length=1, max_length=MAX_TERMS), BeforeValidator(_as_list)]
    unit: str
    plausible: Positive
    source: Text
    shape: Annotated[dict[Word, ParameterTable], Field(max_length=MAX_PARAMETERS)] = {}
    origin: OriginTable | None = None


@dataclass(frozen=True, slots=True, eq=False)
class EffectFile:
    """An `effect/1`: its ``text`` as it stands in a file, ``sha256`` of its bytes, its term, where it is from."""

    text: str
    sha256: str
    term: TermEffect
    origin: OriginTable | None = None

    @property
    def name(self) -> str:
        """Its name as findings have it: gyroscope.dead_zone."""
        return f"{self.term.triad}.{self.term.name}"

    @property
    def is_only_proposed(self) -> bool:
        """Return whether a search found it and no other data confirmed it yet."""
        return self.origin is not None and self.origin.confidence == "proposed"

    @property
    def effect(self) -> Effect:
        """It as a diagnosis takes it."""
        return self.term.effect()


def read_effect(path: Path) -> EffectFile:
    """Read an `effect/1` that somebody names; what was recorded under a name keeps it: `effect_in`.

    Raises
    ------
    DataRefused
        With the line and, in a term, the column of what is wrong; if the catalogue has its name.
    """
    found = effect_in(content := read_text_file(path, MAX_BYTES), path)
    if any(effect.name == found.name for effect in EFFECTS):
        at = line_of(("name",), line_of_keys(content.decode()))
        raise DataRefused(path, at, f"{found.name}, which the catalogue has", "a name of its own", "rename it")
    return found


def each_once(found: Sequence[tuple[Path, EffectFile]]) -> tuple[EffectFile, ...]:
    """Return effects that were read from paths, those of the same bytes once.

    Raise `DataRefused` if two that differ have one name.
    """
    by_name = dict[str, EffectFile]()
    for path, one in found:
        known = by_name.setdefault(one.name, one)
        if known.sha256 != one.sha256:
            expected = f"the one that is used already (sha256 {known.sha256[:12]})"
            raise DataRefused(path, None, f"another {one.name} (sha256 {one.sha256[:12]})", expected, "use one")
    return tuple(by_name.values())


def effect_in(content: bytes, path: Path) -> EffectFile:
    """Return the `effect/1` in a file's bytes, whatever its name; raises `DataRefused` as `read_effect` does."""
    if len(content) > MAX_BYTES:
        raise DataRefused(path, None, f"{len(content)} bytes", f"an effect/1 of at most {MAX_BYTES}")
    table, lines = read_tables(content, path, EffectTable)
    for key, one in table.shape.items():
        if one.low > one.high:
            at = line_of(("shape", key), lines)
            raise DataRefused(path, at, f"low = {one.low:g} above high = {one.high:g}", "low below high")
    return EffectFile(
        content.decode(), hashlib.sha256(content).hexdigest(), _term(table, path, lines), table.origin
    )


@cache
def stored_effect(definition: str, sha256: str, name: str) -> EffectFile:
    """Return the `effect/1` whose text a solution or a calibration holds under ``name``.

    Raise `DataRefused` if it is none, or has another hash or name than was stored.
    """
    found = effect_in(definition.encode(), Path(f"effects.{name}.definition"))
    if (found.sha256, found.name) != (sha256, name):
        stands = f"{found.name} with sha256 {found.sha256}"
        raise DataRefused(f"effects.{name}", None, stands, f"{name} with sha256 {sha256}", "take what was stored")
    return found


def _term(table: EffectTable, path: Path, lines: dict[Key, int]) -> TermEffect:
    shape = {name: Parameter(one.unit, one.low, one.high) for name, one in table.shape.items()}
    units = {("unit",): table.unit} | {("shape", name, "unit"): one.unit for name, one in shape.items()}
    key: Key = ("term",)
    try:
        for key in units:
            parse_unit(units[key])
        key = ("term",)
        return TermEffect(
            table.name, table.triad, tuple(table.term), table.unit, table.plausible, table.source, shape
        )
    except TermRefused as error:
        if key == ("term",) and error.text in table.shape and error.text not in table.term:  # a name that is taken
            key = ("shape", error.text)
        at = line_of(key, lines)
        raise DataRefused(
            path, at, f"{error.found} at column {error.at + 1} of {_near(error)!r}", error.expected, "correct it"
        ) from None


def _near(error: TermRefused) -> str:
    """Return a term, of a long one what stands about the place that is wrong."""
    begin = max(error.at - MAX_SHOWN // 2, 0) if len(error.text) > MAX_SHOWN else 0
    part = error.text[begin : begin + MAX_SHOWN]
    return f"{'...' * (begin > 0)}{part}{'...' * (begin + MAX_SHOWN < len(error.text))}"


def check_stored(session: "Session") -> None:
    """Raise `Altered` if an event of effects, of whatever unit, is not what was stored.

    Which effects are in force is then not known.
    """
    from fixtures_db.imu_models import verify_effects  # a solve without a database does not wait for SQL

    for fault in verify_effects(session):
        raise Altered(fault.row, fault.found, fault.expected, "restore the database from a copy")
