"""A campaign solved now against what was known of it before."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from fixtures_db.model_limits import Limit
from station.results.parameters_by_name import Parameter, ParameterShift, applied, parameters, shifts
from station.results.resolve.previous_solution import KnownCampaign, PreviousSolution
from station.results.verdict import judge

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_FOLDER = re.compile(r"\S*/(?=[^\s/])")  # what stands before a file's name: as it was typed


def altered(known: KnownCampaign, seen: Mapping[str, Any]) -> list[dict[str, str]]:
    """Return every file that is not what was recorded: file, found, expected and which record says so.

    ``seen`` is what `station.results.resolve.campaign_task.check_files` found. The records are ``SHA256SUMS``, the
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
    said: dict[str, Any] = {
        "verdict": {"before": _verdict(before, limits), **verdict},
        "shifts": {name: _row(one, old[name]) for name, one in shifts(new, old, _sigma_before).items()},
        "lost": [name for name in old if name not in new],
        "gained": [name for name in new if name not in old],
    }
    if before.warnings is not None:
        then = {_alike(text) for text in before.warnings}
        said["new_warnings"] = [text for text in now["warnings"] if _alike(text) not in then]
    return said


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
