"""What changed in a diagnosis: its verdict, findings that came or went, how sure a name is."""

from typing import Any

from station.results.resolve.diagnosis_comparison import compare_diagnoses, diagnosis_remarks


def finding(effect: str, confidence: str = "established", *aliases: str) -> dict[str, Any]:
    return {"effect": effect, "confidence": confidence, "aliases": list(aliases)}


def compared(now: tuple[str, list[dict[str, Any]]], before: tuple[str, list[dict[str, Any]]]) -> dict[str, Any]:
    new, old = ({"verdict": verdict, "findings": findings} for verdict, findings in (now, before))
    return {"diagnosis": compare_diagnoses(new, old)}


def test_the_same_diagnosis_in_another_order_is_no_change() -> None:
    both = [finding("fixture.parallelism", "ambiguous", "a.b", "c.d"), finding("slab.tilt")]
    again = [finding("slab.tilt"), finding("fixture.parallelism", "ambiguous", "c.d", "a.b")]
    assert list(diagnosis_remarks(compared(("ambiguous", both), ("ambiguous", again)))) == []


def test_what_came_what_went_and_what_is_surer_is_said() -> None:
    before = [finding("slab.tilt"), finding("accelerometer.quadratic", "ambiguous", "fixture.parallelism")]
    now = [finding("accelerometer.quadratic"), finding("gyroscope.magnetic", "likely")]
    entry = compared(("likely", now), ("ambiguous", before))
    assert list(diagnosis_remarks(entry)) == [
        "diagnosis: ambiguous before, likely now",
        "found now: gyroscope.magnetic, likely",
        "no more found: slab.tilt, established",
        "accelerometer.quadratic: ambiguous (or fixture.parallelism) before, established now",
    ]
    assert entry["diagnosis"]["changed"] == [
        {"effect": "accelerometer.quadratic", "before": "ambiguous (or fixture.parallelism)", "now": "established"}
    ]


def test_a_second_seating_that_was_off_is_one_more_finding() -> None:
    once, twice = [finding("placement.dwell")], [finding("placement.dwell"), finding("placement.dwell")]
    assert compared(("established", twice), ("established", once))["diagnosis"]["gained"] == once
    assert compared(("established", once), ("established", twice))["diagnosis"]["lost"] == once


def test_with_none_before_there_is_a_verdict_and_nothing_to_say() -> None:
    said = compare_diagnoses({"verdict": "consistent", "findings": []}, None)
    assert said == {"verdict": {"now": "consistent"}, "findings": []}
    assert list(diagnosis_remarks({"diagnosis": said})) == []
