"""Effects in words, one tried on campaigns, and one of a diagnosis adopted as an `effect/1` with its source.

A campaign confirms an effect that a search proposed only if its data had no part in finding it.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.term.inputs import input_of
from procedures.inference.result import Diagnosis
from procedures.statistics.significance import log_chi2_sf
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, effects_of
from station.files.effect_file import DIGITS, EffectFile, OriginTable, effect_in, read_effect, stored_effect
from station.files.toml_file import read_text_file, toml_text, toml_value
from station.results.diagnosis.diagnosis_json import finding_document
from station.results.diagnosis.finding_wording import probability_text
from station.results.diagnosis.magnetic_field import with_magnetic_field
from station.results.solution_text import measured

PROPOSED = "proposed"
LEFT = ("unexplained", "partly")  # verdicts that leave more than noise: a reading that is not the law does
MAX_LOG_P = np.log(0.01)  # of coefficients of zero


def recordings(document: Mapping[str, Any]) -> list[str]:
    """Return the first digits of the hash of every recording of a `diagnosis/2`: the same in whatever folder."""
    return sorted({sha256[:DIGITS] for name, sha256 in _files(document).items() if not name.endswith(".toml")})


def why_not_confirmed(document: Mapping[str, Any], entry: Mapping[str, Any], origin: OriginTable) -> str:
    """Return why a `diagnosis/2` with an effect in its model from the start does not confirm it, empty if it does.

    None of its recordings may have had a part in finding it, its coefficients must differ from zero, and noise
    be what is left with it. ``entry`` is the solution's of the effect.
    """
    # two campaigns by one plan have one campaign.toml: it decides only where an origin names no recordings
    tomls = set[str]() if origin.data else {text.split()[-1] for text in origin.campaigns}
    if set(recordings(document)) & set(origin.data) or set(_files(document).values()) & tomls:
        return "it was found in some of these recordings"
    if "coefficients" not in entry:
        return "the diagnosis proposes it, but its model did not include it from the start"
    if document.get("verdict") in LEFT:
        return f"with it in the model the verdict is {document['verdict']}"
    shape = entry.get("units", {})
    sigmas = [one["value"] / one["std"] for name, one in entry["coefficients"].items() if name not in shape]
    if not sigmas or log_chi2_sf(float(np.sum(np.square(sigmas))), len(sigmas)) >= MAX_LOG_P:
        return "its coefficients do not differ from zero here"
    return ""


def _files(document: Mapping[str, Any]) -> dict[str, str]:
    origin = document.get("solution", document).get("provenance", {})
    return {str(name): str(sha256) for name, sha256 in origin.get("files", {}).items()}


def confidence_text(file: EffectFile, why: str = "") -> str:
    """Return how sure an adopted effect is, and ``why`` not surer; nothing of one that no search found."""
    if file.is_only_proposed:
        why = why or "only the data in which it was found show it"
        return f"proposed: {why}; diagnose a later campaign with --effects and adopt it from there"
    if file.origin is not None and file.origin.confidence:
        return f"confirmed by {', '.join(file.origin.confirmed_by)}"
    return ""


MAX_BYTES = 2**26
MAX_ORIGIN = 300  # characters


def adopted(diagnosis: Path, wanted: str | None, out: Path) -> tuple[EffectFile, str]:
    """Write the effect of a `diagnosis/2` to ``out``; return it, and why it is not confirmed where it might be.

    ``wanted`` is a finding's number in the diagnosis, from 1, or an effect's name; None: the only one with a term.

    Raise `DataRefused` if the file is no `diagnosis/2`, has no such effect, or the effect is not what its hash
    says; `CannotWrite` if ``out`` cannot be written.
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
    unit, files = f"{origin.get('model', '?')} {origin.get('serial', '?')}", _files(document).items()
    tomls = [f"{unit} {name} {sha256}"[:MAX_ORIGIN] for name, sha256 in files if name.endswith("campaign.toml")]
    return tomls or [f"{unit} {diagnosis.name}"]


def _name(entry: Mapping[str, Any]) -> str:
    """Return the effect's name, as a finding or as a solution has it."""
    return str(entry.get("effect", entry.get("name")))


def effect_text(name: str, in_force: Sequence[str] = ()) -> str:
    """Return what is known of an effect of the catalogue, or of a file of `effect/1`.

    ``in_force`` are the names of the database, which a refusal lists.

    Raise `DataRefused` if there is neither, or the file is no `effect/1`.
    """
    if (known := next((effect for effect in EFFECTS if effect.name == name), None)) is not None:
        return "\n".join([f"{name}: in the catalogue", *_lines(known)])
    if not Path(name).exists():
        known_names = ", ".join([*in_force, *(effect.name for effect in EFFECTS)])
        expected = f"a file of effect/1, or one of {known_names}"
        raise DataRefused(name, None, "no such error term", expected, "check the name")
    return file_text(read_effect(Path(name)))


def file_text(file: EffectFile) -> str:
    """Return what an `effect/1` says."""
    lines = [f"{file.name}: effect/1, sha256 {file.sha256}", *_lines(file.effect)]
    for name, one in file.term.parameters.items():
        lines.append(f"  {name:<10} fitted between {one.low:g} and {one.high:g} {one.unit}")
    for name in file.term.inputs:
        known = input_of(name, file.term.triad)
        lines.append(f"  {name:<10} {known.meaning} [{known.unit}]" if known is not None else f"  {name}")
    if file.term.looks_back:
        lines.append(
            "  it is specific to the campaign or to earlier steps: it is in the solution "
            "and is not corrected in later samples"
        )
    if (origin := file.origin) is not None:
        lines.append(
            f"  adopted on {origin.date} from {', '.join(origin.campaigns)}, diagnosis {origin.diagnosis_sha256}"
        )
    if text := confidence_text(file):
        lines.append(f"  {text}")
    return "\n".join(lines)


def _lines(effect: Effect) -> list[str]:
    unit = f"{effect.unit}, plausible {effect.plausible:g}"
    return [f"  adds       {effect.physics}", f"  unit       {unit}", f"  source     {effect.source}"]


def tried_text(file: EffectFile, campaigns: Sequence[LoadedCampaign]) -> str:
    """Return whether one unit's campaigns show an effect, with its coefficients, and what else it could be."""
    campaigns = [with_magnetic_field(one) for one in campaigns]
    declared = [one.term for one in effects_of(campaigns) if one.name != file.name]
    found = diagnose([one.campaign for one in campaigns], (*EFFECTS, file.effect), declared)
    lines = [f"{file.name}: {_answer(file, found)}", *_findings(file, found)]
    others = dict.fromkeys(one.effect for one in found.findings if one.effect != file.name)
    lines += [f"also in the model: {', '.join(others)}"] if others else []
    return "\n".join([*lines, f"verdict: {found.verdict}"])


def _answer(file: EffectFile, found: Diagnosis) -> str:
    named = [one for one in found.findings if one.effect == file.name]
    if named:
        return f"it is present, {named[0].confidence} (probability {probability_text(named[0].probability)})"
    if missing := file.term.missing(found.evidence.excitation):
        return f"not tested: {', '.join(missing)} not recorded"
    if alike := [one.effect for one in found.findings if file.name in one.aliases]:
        return f"these campaigns cannot separate it from {', '.join(alike)}"
    if file.name in found.not_separable or file.name not in found.probabilities:
        return "these campaigns cannot determine it: the model's own parameters absorb it, or nothing excites it"
    return f"not found: its probability is {probability_text(found.probabilities[file.name])}"


def _findings(file: EffectFile, found: Diagnosis) -> list[str]:
    lines = list[str]()
    units = {name: one.unit for name, one in file.term.parameters.items()}
    for one in (one for one in found.findings if one.effect == file.name):
        for name, value in finding_document(one)["coefficients"].items():
            lines.append(f"  {name:<10} {measured(value['value'], value['std'], units.get(name, one.unit))}")
        values = dict(zip(one.coefficients, one.value.tolist(), strict=True))
        lines += [f"  {text}" for text in file.term.at_ends(values)]
        lines += [f"  it may also be {', '.join(one.aliases)}"] if one.aliases else []
    return lines
