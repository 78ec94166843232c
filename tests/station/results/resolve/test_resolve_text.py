"""A resolve/1 written by hand, as it is read; what changed in a diagnosis."""

from typing import Any

import pytest

from station.results.resolve.comparison import compare_diagnoses, diagnosis_remarks
from station.results.resolve.fleet import exit_code, resolve_text, shift_of

BIAS = "accelerometer.bias.z"


def entry(**more: Any) -> dict[str, Any]:
    return {"folder": "/data/S1", "model": "FOG3", "serial": "S1", "outcome": "solved", "before": "x"} | more


def moved(by: float, sigmas: float) -> dict[str, Any]:
    row = {"before": 1e-3, "now": 1e-3 + by, "std_before": abs(by / sigmas), "unit": "g", "shift_sigma": sigmas}
    return {BIAS: row}


def text_of(*entries: dict[str, Any]) -> list[str]:
    text = resolve_text({"software": "0.1", "campaigns": list(entries)})
    return " ".join(text.split()).split("/data/")


def verdict(before: str | None, now: str, limits: int = 3) -> dict[str, Any]:
    found = {"now": now, "limits": limits, "reason": "bias z"}
    return {"verdict": found | ({"before": before} if before else {})}


@pytest.mark.parametrize(
    ("before", "now", "code", "counted"),
    [
        ("PASS", "FAIL", 1, "1 turned FAIL, 1 with another verdict"), ("FAIL", "FAIL", 0, ""),
        ("FAIL", "PASS", 0, "1 with another verdict"), ("PASS", "PASS", 0, ""), (None, "FAIL", 0, ""),
    ],
)  # fmt: skip
def test_a_verdict_that_turned_is_counted_reported_and_ends_the_command_with_1(
    before: str | None, now: str, code: int, counted: str
) -> None:
    one = entry(**verdict(before, now))
    assert exit_code({"campaigns": [entry(), one]}) == code
    first, *remarks = text_of(one)
    assert first.strip() == ", ".join(each for each in ("1 campaign, 0.1: 1 solved", counted) if each)
    assert remarks == ([f"S1 FOG3 S1 {before} before, {now} now: bias z"] if counted else [])


def test_shifts_are_summed_up_and_reported_of_one_sigma_or_more() -> None:
    entries = [entry(shifts=moved(2e-5, 0.5)), entry(folder="/data/S2", serial="S2", shifts=moved(-4e-5, -3.0)),
               entry(folder="/data/S3", shifts=moved(3e-5, 1.0)), entry()]  # fmt: skip
    found = shift_of(entries[1])
    assert found is not None
    assert (found.parameter.name, found.sigmas) == (BIAS, -3.0)
    assert found.shift == pytest.approx(-4e-5)
    assert shift_of(entries[3]) is None
    first, *remarks = text_of(*entries)
    reported = "median 1, at most 3, accelerometer bias z of FOG3 S2"
    assert f"largest change of a campaign, in units of its earlier uncertainty u: {reported}" in first
    assert [each.split(" moved: accelerometer bias z ")[0] for each in remarks] == ["S2 FOG3 S2", "S3 FOG3 S1"]
    assert [each.rpartition(" (")[2].strip() for each in remarks] == ["3.0 u)", "1.0 u)"]


def test_the_exit_code_is_that_of_the_first_refusal_where_nothing_is_solved() -> None:
    folder, faces = entry(outcome="refused", exit_code=3), entry(outcome="refused", exit_code=5)
    assert exit_code({"campaigns": [faces]}) == 5
    assert exit_code({"campaigns": [entry(outcome="missing", exit_code=3), faces]}) == 3
    assert exit_code({"campaigns": [folder, faces, entry()]}) == 0  # named, and stops no other
    assert exit_code({"campaigns": [entry(outcome="refused", exit_code=3, altered=[{}])]}) == 1


def finding(effect: str, confidence: str = "established", *aliases: str) -> dict[str, Any]:
    return {"effect": effect, "confidence": confidence, "aliases": list(aliases)}


def compared(now: tuple[str, list[dict[str, Any]]], before: tuple[str, list[dict[str, Any]]]) -> dict[str, Any]:
    new, old = ({"verdict": verdict, "findings": findings} for verdict, findings in (now, before))
    return {"diagnosis": compare_diagnoses(new, old)}


def test_what_came_what_went_and_what_is_surer_is_reported() -> None:
    before = [finding("slab.tilt"), finding("accelerometer.quadratic", "possible", "fixture.parallelism")]
    now = [finding("accelerometer.quadratic"), finding("gyroscope.magnetic", "likely")]
    entry = compared(("likely", now), ("ambiguous", before))
    assert list(diagnosis_remarks(entry)) == [
        "diagnosis: ambiguous before, likely now",
        "found now: gyroscope.magnetic, likely",
        "no more found: slab.tilt, established",
        "accelerometer.quadratic: possible (or fixture.parallelism) before, established now",
    ]
    assert entry["diagnosis"]["changed"] == [
        {"effect": "accelerometer.quadratic", "before": "possible (or fixture.parallelism)", "now": "established"}
    ]
