"""A campaign's diagnosis now against the one that was known of it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from station.results.measurement_circumstances import diagnosis_kept

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
        "lost": [_kept(one) for name, one in old.items() if name not in new],
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
    said = entry.get("diagnosis", {})
    verdict = said.get("verdict", {})
    is_other = "before" in verdict and verdict["before"] != verdict["now"]
    return is_other or any(said.get(what) for what in ("gained", "lost", "changed"))


def diagnosis_remarks(entry: Mapping[str, Any]) -> Iterator[str]:
    """Yield what changed in a campaign's diagnosis."""
    if not is_otherwise(entry):
        return
    said = entry["diagnosis"]
    was, now = said["verdict"]["before"], said["verdict"]["now"]
    yield f"diagnosis: {now}, as before" if was == now else f"diagnosis: {was} before, {now} now"
    for one in said["gained"]:
        yield f"found now: {one['effect']}, {in_words(one)}"
    for one in said["lost"]:
        yield f"no more found: {one['effect']}, {in_words(one)}"
    for row in said["changed"]:
        yield f"{row['effect']}: {row['before']} before, {row['now']} now"


def _by_name(findings: Sequence[Finding]) -> dict[tuple[str, int], Finding]:
    """Return findings by effect, and a number where an effect was found more than once."""
    named = dict[tuple[str, int], Finding]()
    for one in findings:
        named[one["effect"], sum(effect == one["effect"] for effect, _ in named)] = one
    return named


def _kept(finding: Finding) -> dict[str, Any]:
    return {name: finding[name] for name in ("effect", "confidence", "aliases")}
