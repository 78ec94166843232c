"""A campaign solved and diagnosed now, against what was known of it before.

Before is its newest stored calibration, else the ``solution.json`` in its folder.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from sqlalchemy.orm import Session

from fixtures_db.campaigns import known_campaign
from fixtures_db.imu_models import Limit
from fixtures_db.stored_calibrations import newest_calibration
from station.errors import DataRefused
from station.files.toml_file import read_text_file
from station.results.measurement_circumstances import KEPT, diagnosis_kept
from station.results.parameters_by_name import Parameter, ParameterShift, applied, parameters, shifts
from station.results.verdict import judge

SOLUTION, DIAGNOSIS = "solution.json", "diagnosis.json"
MAX_BYTES = 2**26  # bytes


@dataclass(frozen=True, slots=True)
class PreviousSolution:
    """A `calibration/1` or `solution/1` of the same campaign; ``name`` is its hash or its file.

    ``warnings`` is None where nobody wrote them down: a calibration has none of its own. ``diagnosis`` has
    verdict and findings; None where none is known.
    """

    kind: Literal["calibration", "solution"]
    name: str
    document: Mapping[str, Any]
    warnings: tuple[str, ...] | None
    diagnosis: Mapping[str, Any] | None = None

    @property
    def inputs(self) -> Mapping[str, str]:
        """The SHA-256 of each file that it was made from."""
        found: Mapping[str, str] = self.document.get("inputs") or self.document["provenance"]["files"]
        return found


@dataclass(frozen=True, slots=True)
class KnownCampaign:
    """What database and folder know of a campaign; ``steps`` has the SHA-256 of each accepted step's file."""

    folder: str
    steps: Mapping[str, str]
    before: PreviousSolution | None


def known_of(session: Session, folder: str) -> KnownCampaign:
    """Return what is known of the campaign of a folder (its resolved path)."""
    row, stored, solved = known_campaign(session, folder), newest_calibration(session, folder), _solved(folder)
    steps = {} if row is None else {step.file: step.sha256 for step in row.steps}
    if stored is None:
        return KnownCampaign(folder, steps, solved)
    document = json.loads(stored.document)
    is_same = solved is not None and solved.inputs == document["inputs"]
    warnings = solved.warnings if solved is not None and is_same else None
    diagnosis = document.get("diagnosis") or _diagnosed(folder, document["inputs"])
    return KnownCampaign(
        folder, steps, PreviousSolution("calibration", stored.sha256, document, warnings, diagnosis)
    )


def _diagnosed(folder: str, files: Mapping[str, str]) -> Mapping[str, Any] | None:
    """Return what the folder's ``diagnosis.json`` found in the same files, None if that cannot be read."""
    try:
        document = json.loads(read_text_file(Path(folder) / DIAGNOSIS, MAX_BYTES))
        is_same = document["format"] == "diagnosis/2" and document["solution"]["provenance"]["files"] == files
        return diagnosis_kept(document) if is_same else None
    except (DataRefused, ValueError, KeyError, TypeError):
        return None


def _solved(folder: str) -> PreviousSolution | None:
    """Return the folder's ``solution.json``, None if there is none that can be read: it is no record."""
    path = Path(folder) / SOLUTION
    try:
        document = json.loads(read_text_file(path, MAX_BYTES))
        if document["format"] != "solution/1":
            return None
        parameters(document)
        files = document["provenance"]["files"]
        before = PreviousSolution(
            "solution", str(path), document, tuple(document["warnings"]), _diagnosed(folder, files)
        )
        return before if before.inputs else None
    except (DataRefused, ValueError, KeyError, TypeError, IndexError, AttributeError):
        return None


_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_FOLDER = re.compile(r"\S*/(?=[^\s/])")  # what stands before a file's name: as it was typed


def altered(known: KnownCampaign, seen: Mapping[str, Any]) -> list[dict[str, str]]:
    """Return every file that is not what was recorded: file, found, expected and which record says so.

    ``seen`` is what `station.results.resolve.fleet.check_files` found. The records are ``SHA256SUMS``, the
    database's accepted steps and the files that the stored calibration was made from. A ``solution.json`` is no
    record.
    """
    found, sums = seen["found"], seen["sums"]
    records: list[tuple[str, Mapping[str, str]]] = [("SHA256SUMS", sums or {}), ("database", known.steps)]
    if known.before is not None and known.before.kind == "calibration":
        records.append(("calibration", known.before.inputs))
    rows = dict[str, dict[str, str]]()
    for record, hashes in records:
        for name, sha256 in hashes.items():
            if (now := found.get(name, "no such file")) != sha256:
                rows.setdefault(name, {"file": name, "found": now, "expected": sha256, "record": record})
    if seen["fault"]:
        rows["SHA256SUMS"] = _unhashed("SHA256SUMS", seen["fault"], "readable hashes")
    for name in seen["inputs"] if sums is not None else ():
        if name not in sums and name != "campaign.toml":
            rows.setdefault(name, _unhashed(name, "a step without a hash", "a line in SHA256SUMS"))
    return list(rows.values())


def _unhashed(name: str, found: str, expected: str) -> dict[str, str]:
    return {"file": name, "found": found, "expected": expected, "record": "SHA256SUMS"}


def compare(now: Mapping[str, Any], before: PreviousSolution | None, limits: Sequence[Limit]) -> dict[str, Any]:
    """Return what changed between a `solution/1` and what was known, as the campaign's part of `resolve/1`."""
    judged = judge(now, limits)
    verdict = {"now": judged.word, "limits": len(limits), "reason": judged.reason}
    if before is None:
        return {"verdict": verdict}
    new, old = applied(parameters(now)), applied(parameters(before.document))
    stated: dict[str, Any] = {
        "verdict": {"before": _verdict(before, limits), **verdict},
        "shifts": {name: _row(one, old[name]) for name, one in shifts(new, old, _sigma_before).items()},
        "lost": [name for name in old if name not in new],
        "gained": [name for name in new if name not in old],
    }
    if before.warnings is not None:
        then = {_alike(text) for text in before.warnings}
        stated["new_warnings"] = [text for text in now["warnings"] if _alike(text) not in then]
    return stated


def _alike(warning: str) -> str:
    """Return a warning without digits and folders: one that moved or was typed otherwise is not new."""
    return _NUMBER.sub("#", _FOLDER.sub("", warning))


def _sigma_before(_: Parameter, before: Parameter) -> float:
    """Return the sigma *of the one before*.

    Both come from the same counts, so that their errors are not independent and the root of the sum of squares
    would be too wide: the question is how far off, in its own terms, is what was handed out.
    """
    return before.std or 0.0


def _row(shift: ParameterShift, before: Parameter) -> dict[str, Any]:
    now = shift.parameter
    return {
        "before": before.value,
        "now": now.value,
        "unit": now.unit,
        "std_before": before.std,
        "std_now": now.std,
        "shift_sigma": shift.sigmas,
    }


def _verdict(before: PreviousSolution, limits: Sequence[Limit]) -> str:
    """Return the verdict of what was known, on the limits of today.

    A calibration holds only what it applies. Where its limits were those of today, the verdict that it was given
    stands; else the limits of what it holds decide.
    """
    document = before.document
    if before.kind == "solution":
        return judge(document, limits).word
    kept = [{key: value for key, value in asdict(one).items() if value is not None} for one in limits]
    if "verdict" in document and document.get("limits") == kept:
        return str(document["verdict"])
    held = parameters(document)
    return judge(document, [one for one in limits if one.parameter in held]).word


Finding = Mapping[str, Any]


def compare_diagnoses(now: Mapping[str, Any], before: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what changed in a diagnosis; ``now`` is a `diagnosis/2`, ``before`` may be a calibration's.

    ``gained`` and ``lost`` are findings; ``changed`` are those of both with another confidence or other aliases.
    """
    found = diagnosis_kept(now)
    if before is None:
        return {"verdict": {"now": found["verdict"]}, "findings": found["findings"]}
    new, old = _by_name(found["findings"]), _by_name(before["findings"])
    return {
        "verdict": {"before": before["verdict"], "now": found["verdict"]},
        "findings": found["findings"],
        "gained": [one for name, one in new.items() if name not in old],
        "lost": [{key: one[key] for key in KEPT} for name, one in old.items() if name not in new],
        "changed": [
            {"effect": one["effect"], "before": in_words(old[name]), "now": in_words(one)}
            for name, one in new.items()
            if name in old and in_words(old[name]) != in_words(one)
        ],
    }


def in_words(finding: Finding) -> str:
    """Return how sure a finding is, and what it could be instead."""
    instead = f" (or {', '.join(sorted(finding['aliases']))})" if finding["aliases"] else ""
    return f"{finding['confidence']}{instead}"


def is_otherwise(entry: Mapping[str, Any]) -> bool:
    """Say whether a campaign's diagnosis has another verdict, or findings, than before."""
    stated = entry.get("diagnosis", {})
    verdict = stated.get("verdict", {})
    is_other = "before" in verdict and verdict["before"] != verdict["now"]
    return is_other or any(stated.get(what) for what in ("gained", "lost", "changed"))


def diagnosis_remarks(entry: Mapping[str, Any]) -> Iterator[str]:
    """Yield what changed in a campaign's diagnosis."""
    if not is_otherwise(entry):
        return
    stated = entry["diagnosis"]
    was, now = stated["verdict"]["before"], stated["verdict"]["now"]
    yield f"diagnosis: {now}, as before" if was == now else f"diagnosis: {was} before, {now} now"
    for one in stated["gained"]:
        yield f"found now: {one['effect']}, {in_words(one)}"
    for one in stated["lost"]:
        yield f"no more found: {one['effect']}, {in_words(one)}"
    for row in stated["changed"]:
        yield f"{row['effect']}: {row['before']} before, {row['now']} now"


def _by_name(findings: Sequence[Finding]) -> dict[tuple[str, int], Finding]:
    """Return findings by effect, and a number where an effect was found more than once."""
    named = dict[tuple[str, int], Finding]()
    for one in findings:
        named[one["effect"], sum(effect == one["effect"] for effect, _ in named)] = one
    return named
