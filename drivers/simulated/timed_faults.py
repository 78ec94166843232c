"""Faults that last: from a true time on, for some seconds."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

from drivers.simulated.errors import TruthRefused


@dataclass(frozen=True, slots=True)
class TimedFault:
    """One fault, from true time ``at_s`` on for ``seconds``; what ``size`` is depends on the kind."""

    kind: str
    at_s: float
    seconds: float = 1.0
    size: float = 0.0


F = TypeVar("F", bound=TimedFault)


def active(faults: Iterable[F], now: float, kind: str) -> list[F]:
    """Return the faults of a kind that act at true time ``now`` [s]."""
    return [fault for fault in faults if fault.kind == kind and fault.at_s <= now < fault.at_s + fault.seconds]


def timed_faults_from(
    tables: Iterable[Mapping[str, Any]], fault: type[F], name: str, kinds: Mapping[str, str]
) -> tuple[F, ...]:
    """Return the faults of parsed tables ``[[name]]``; raise `TruthRefused` naming what is accepted."""
    accepted = {f.name for f in fields(fault)}
    found = []
    for table in tables:
        if unknown := sorted(set(table) - accepted):
            raise TruthRefused(f"{name} key {unknown[0]!r}", ", ".join(sorted(accepted)))
        if table.get("kind") not in kinds:
            raise TruthRefused(f"{name} kind {table.get('kind')!r}", ", ".join(kinds))
        for key, value in {"at_s": None, **table}.items():
            if key != "kind" and (isinstance(value, bool) or not isinstance(value, (int, float))):
                raise TruthRefused(f"{name} {key} = {value!r}", "a number")
        found.append(fault(**table))
    return tuple(found)
