"""A `resolve/1` written by hand, as it is read."""

from typing import Any

import pytest

from station.results.resolve.resolve_text import exit_code, resolve_text, shift_of

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


def test_campaigns_are_counted_by_what_became_of_them() -> None:
    (counted,) = text_of(entry(), entry(was_kept=True), entry(folder="x", before="y"))
    assert counted == "3 campaigns, 0.1: 3 solved, 1 of them kept from an earlier run"
    new = {key: value for key, value in entry().items() if key != "before"}
    assert text_of(new) == ["1 campaign, 0.1: 1 solved, 1 with nothing to compare with"]


@pytest.mark.parametrize(
    ("before", "now", "code", "counted"),
    [
        ("PASS", "FAIL", 1, "1 turned FAIL, 1 with another verdict"), ("FAIL", "FAIL", 0, ""),
        ("FAIL", "PASS", 0, "1 with another verdict"), ("PASS", "PASS", 0, ""), (None, "FAIL", 0, ""),
    ],
)  # fmt: skip
def test_a_verdict_that_turned_is_counted_said_and_ends_the_command_with_1(
    before: str | None, now: str, code: int, counted: str
) -> None:
    one = entry(**verdict(before, now))
    assert exit_code({"campaigns": [entry(), one]}) == code
    first, *remarks = text_of(one)
    assert first.strip() == ", ".join(each for each in ("1 campaign, 0.1: 1 solved", counted) if each)
    assert remarks == ([f"S1 FOG3 S1 {before} before, {now} now: bias z"] if counted else [])


def test_a_verdict_without_limits_is_called_so() -> None:
    assert "PASS before, NO LIMITS now" in text_of(entry(**verdict("PASS", "NOT_MEASURED", limits=0)))[1]
    assert "PASS before, NOT MEASURED now" in text_of(entry(**verdict("PASS", "NOT_MEASURED")))[1]


def test_shifts_are_summed_up_and_told_of_one_sigma_or_more() -> None:
    entries = [entry(shifts=moved(2e-5, 0.5)), entry(folder="/data/S2", serial="S2", shifts=moved(-4e-5, -3.0)),
               entry(folder="/data/S3", shifts=moved(3e-5, 1.0)), entry()]  # fmt: skip
    found = shift_of(entries[1])
    assert found is not None
    assert (found.parameter.name, found.sigmas) == (BIAS, -3.0)
    assert found.shift == pytest.approx(-4e-5)
    assert shift_of(entries[3]) is None
    first, *remarks = text_of(*entries)
    said = "median 1, at most 3, accelerometer bias z of FOG3 S2"
    assert f"largest shift of a campaign, in its own sigma as known before: {said}" in first
    assert [each.split(" moved: accelerometer bias z ")[0] for each in remarks] == ["S2 FOG3 S2", "S3 FOG3 S1"]
    assert [each.rpartition(" (")[2].strip() for each in remarks] == ["3.0 sigma)", "1.0 sigma)"]


def test_the_exit_code_is_that_of_the_first_refusal_where_nothing_is_solved() -> None:
    folder, faces = entry(outcome="refused", exit_code=3), entry(outcome="refused", exit_code=5)
    assert exit_code({"campaigns": [faces]}) == 5
    assert exit_code({"campaigns": [entry(outcome="missing", exit_code=3), faces]}) == 3
    assert exit_code({"campaigns": [folder, faces, entry()]}) == 0  # named, and stops no other
    assert exit_code({"campaigns": [entry(outcome="refused", exit_code=3, altered=[{}])]}) == 1


def test_what_is_missing_refused_altered_lost_or_new_is_said() -> None:
    row = {"file": "a.csv", "found": "12", "expected": "34", "record": "SHA256SUMS"}
    altered = entry(altered=[row])
    assert exit_code({"campaigns": [altered]}) == 1
    assert "S1 FOG3 S1 ALTERED a.csv: found 12, expected 34 (SHA256SUMS)" in text_of(altered)[1]
    assert "no such folder: find it" in text_of(entry(outcome="missing"))[1]
    assert "S1 FOG3 S1 solved before, refused now: dead" in text_of(entry(outcome="refused", reason="dead"))[1]
    new = {key: value for key, value in entry(outcome="refused", reason="dead").items() if key != "before"}
    assert "S1 FOG3 S1 refused: dead" in text_of(new)[1]
    lost = text_of(entry(lost=["slab.tilt"], new_warnings=["short"]))
    assert lost[0].strip() == "1 campaign, 0.1: 1 solved, 1 with new warnings"
    assert lost[1] == "S1 FOG3 S1 no more estimated: slab.tilt new warning: short"
