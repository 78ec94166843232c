"""The hash chain of append-only rows: each text names the SHA-256 of the one before it."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

GENESIS = "0" * 64  # what the first row names as the one before it


def canonical(value: Mapping[str, Any]) -> str:
    """Return the one JSON text of a mapping: keys sorted, no NaN, numbers as their shortest exact decimals."""
    return json.dumps(value, sort_keys=True, allow_nan=False, ensure_ascii=False, separators=(",", ":"))


def digest(text: str) -> str:
    """Return the SHA-256 of a text's UTF-8 bytes, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class Link:
    """An append-only row as the chain sees it: its text and the two hashes that it was stored with."""

    row: str
    text: str
    previous: str
    sha256: str


@dataclass(frozen=True, slots=True)
class ChainFault:
    """A row that does not agree with the chain: what was found there and what was expected."""

    row: str
    found: str
    expected: str

    def __str__(self) -> str:
        return f"{self.row}: found {self.found}, expected {self.expected}"


def faults(links: Iterable[Link]) -> list[ChainFault]:
    """Return every disagreement along a chain, oldest first; none if it is whole.

    A row dropped at the newest end leaves a whole chain: compare the head with one that was kept elsewhere.
    """
    found, head = list[ChainFault](), GENESIS
    for link in links:
        if link.previous != head:
            found.append(ChainFault(link.row, f"previous {link.previous}", head))
        if (actual := digest(link.text)) != link.sha256:
            found.append(ChainFault(link.row, f"text with sha256 {actual}", link.sha256))
        head = link.sha256
    return found


def utc_text(moment: datetime) -> str:
    """Return a moment as written in files: ISO 8601, UTC, ending in Z; refuse one without a time zone."""
    if moment.tzinfo is None:
        raise ValueError(f"{moment!r} has no time zone; expected an aware datetime")
    return moment.astimezone(UTC).isoformat().replace("+00:00", "Z")
