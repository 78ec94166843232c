"""An effect of a diagnosis as an `effect/1` of its own, with where it comes from."""

import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.effect_file import EffectFile, effect_in, stored_effect
from station.files.toml_file import read_text_file, toml_text, toml_value
from station.results.effect_confirmed import PROPOSED, recordings, why_not_confirmed

MAX_BYTES = 2**26
MAX_ORIGIN = 300  # characters


def adopted(diagnosis: Path, wanted: str | None, out: Path) -> tuple[EffectFile, str]:
    """Write the effect of a `diagnosis/2` to ``out``; return it, and why it is not confirmed where it might be.

    ``wanted`` is a finding's number in the diagnosis, from 1, or an effect's name; None: the only one with a term.

    Raises
    ------
    DataRefused
        If the file is no `diagnosis/2`, has no such effect, or the effect is not what its hash says.
    CannotWrite
        If ``out`` cannot be written.
    """
    content = read_text_file(diagnosis, MAX_BYTES)
    document = _document(content, diagnosis)
    entry = _chosen(_with_terms(document), wanted, diagnosis)
    known = stored_effect(
        str(entry["definition"]), str(entry["sha256"]), str(entry.get("effect", entry.get("name")))
    )
    campaigns = _campaigns(document, diagnosis)
    origin: dict[str, Any] = {
        "campaigns": campaigns, "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "diagnosis_sha256": hashlib.sha256(content).hexdigest(), "data": recordings(document),
        **({"confidence": PROPOSED} if entry.get("confidence") == PROPOSED else {}),
    }  # fmt: skip
    text, why = known.text, ""
    if known.origin is None:  # else it was adopted before, and says so
        text = f"{text.rstrip()}\n\n{toml_text({'origin': origin})}"
    elif known.is_only_proposed and not (why := why_not_confirmed(document, entry, known.origin)):
        confirmed = f'confidence = "confirmed"\nconfirmed_by = {toml_value(campaigns)}'
        text = text.replace('confidence = "proposed"', confirmed)
    found = effect_in(text.encode(), out)
    replace_file(out, text.encode())
    return found, why


def _document(content: bytes, path: Path) -> Mapping[str, Any]:
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict) or document.get("format") != "diagnosis/2":
        raise DataRefused(
            path, None, "no diagnosis/2", "the output of `station diagnose --json`", "name that file"
        )
    return document


def _with_terms(document: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the findings that have a term, with their number in the diagnosis, then the declared effects."""
    findings = [(str(i), one) for i, one in enumerate(document.get("findings", ()), 1)]
    declared = [("", one) for one in document.get("solution", {}).get("effects", ())]
    return [
        (number, one)
        for number, one in (*findings, *declared)
        if isinstance(one, dict) and "definition" in one and "sha256" in one
    ]


def _chosen(there: list[tuple[str, Mapping[str, Any]]], wanted: str | None, path: Path) -> Mapping[str, Any]:
    names = ", ".join(f"{number} {_name(one)}".strip() for number, one in there)
    if not there:
        expected = "a finding with a term; the catalogue's effects need no file"
        raise DataRefused(path, None, "no user-defined error term", expected, "diagnose with --effects FILE")
    kept = [one for number, one in there if wanted is None or wanted in (number, _name(one))]
    if len(kept) != 1:
        found = f"{len(kept)} of them" if kept else f"finding {wanted} without its own term"
        raise DataRefused(path, None, found, f"one of {names}", "give --finding N, or its name")
    return kept[0]


def _campaigns(document: Mapping[str, Any], diagnosis: Path) -> list[str]:
    """Return the unit and what its campaign.toml hashed to, as the diagnosis names them."""
    origin = document.get("solution", document).get("provenance", {})
    unit = f"{origin.get('model', '?')} {origin.get('serial', '?')}"
    files = origin.get("files", {})
    tomls = [
        f"{unit} {name} {sha256}"[:MAX_ORIGIN] for name, sha256 in files.items() if name.endswith("campaign.toml")
    ]
    return tomls or [f"{unit} {diagnosis.name}"]


def _name(entry: Mapping[str, Any]) -> str:
    """Return the effect's name, as a finding or as a solution has it."""
    return str(entry.get("effect", entry.get("name")))
