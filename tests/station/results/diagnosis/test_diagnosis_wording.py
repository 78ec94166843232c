"""What a verdict on limits says of a residual that nothing explains."""

from procedures.uncertainty.budget import Contribution, ParameterBudget
from station.results.diagnosis.diagnosis_text import not_looked_at, warnings_of
from station.results.diagnosis.diagnosis_wording import chance_text, left_said, notes, verdict_sentence


def budgeted(source: str) -> ParameterBudget:
    part = Contribution(source, "A", 1e-6, 20.0)
    return ParameterBudget("accelerometer.bias.x", 1e-3, "g", 1e-6, 20.0, 2.1, 2.1e-6, (part,))


def test_only_an_unexplained_residual_is_said_beside_the_limits() -> None:
    for verdict in ("consistent", "established", "likely", "ambiguous"):
        assert left_said({"verdict": verdict}, [budgeted("unexplained")]) == ""
    assert "the uncertainty takes it for scatter" in left_said(
        {"verdict": "unexplained"}, [budgeted("unexplained")]
    )


def test_it_is_not_said_to_be_in_an_uncertainty_that_has_no_such_part() -> None:
    said = left_said({"verdict": "unexplained"}, [budgeted("bias instability")])
    assert "takes it for scatter" not in said
    assert said.endswith("the uncertainty covers only the scatter that the fit found")


def test_a_diagnosis_says_what_its_own_sigmas_leave_out() -> None:
    document = {"verdict": "unexplained", "log10_p": -9.0, "findings": []}
    assert "The sigmas here cover only the scatter" in verdict_sentence(document)


def test_a_cause_that_is_only_too_large_is_named_with_its_size() -> None:
    document = {"verdict": "unexplained", "log10_p": -9.0, "findings": []}
    assert "no known effect explains it" in verdict_sentence(document)
    large = {"too_large": [{"effect": "gyroscope.bias_temperature", "times_plausible": 11.23}]}
    said = verdict_sentence(document | large)
    assert "Found, but 11 times larger than is plausible: gyroscope.bias_temperature." in said
    assert "no known effect" not in said
    assert "Found besides, but 11 times" in verdict_sentence(document | large | {"verdict": "partly"})


def test_where_a_seating_could_be_one_of_two_positions_what_hangs_on_it_is_said() -> None:
    finding = {"where": {"position": [8, 7], "file": "d8.csv"}, "sign_flip_p": 0.007}
    flipped, position = notes(finding)
    assert "7 of 1000 draws" in flipped
    assert "solved as position 8" in position
    assert "misalignments would differ" in position
    assert notes({"where": {"position": 8}}) == []


def test_a_diagnosis_does_not_advise_to_run_a_diagnosis() -> None:
    solution = {"warnings": ["the sigmas are too small; run `station diagnose`", "a gap"]}
    assert warnings_of(solution) == ["the sigmas are too small", "a gap"]


def test_a_chance_is_said_in_plain_words_however_small() -> None:
    said = [chance_text(log10_p) for log10_p in (0.0, -0.42, -2.5, -5.3, -12.2, -400.0)]
    assert said[:2] == ["100 times in 100", "38 times in 100"]
    assert said[2:] == ["once in 300", "once in 200,000", "once in 1e12", "less than once in 1e300"]


def test_a_cause_found_in_part_is_told_from_what_the_model_holds_anyway() -> None:
    bench = {"effect": "fixture.parallelism", "kind": "bench", "confidence": "ambiguous", "aliases": ["slab.tilt"]}
    part = {
        "effect": "gyroscope.scale_nonlinearity",
        "kind": "instrument",
        "confidence": "ambiguous",
        "aliases": [],
    }
    findings = [{**bench, "share": 0.0}, {**part, "share": 0.9}]
    said = verdict_sentence({"verdict": "partly", "log10_p": -20.0, "findings": findings})
    assert "gyroscope.scale_nonlinearity would explain a part of it" in said
    assert "parallelism" not in said


def test_gyroscopes_that_no_residual_was_diagnosed_of_are_said_to_be_not_looked_at() -> None:
    solution = {"accelerometer": {}, "gyroscope": {}}
    document = {"error": [{"quantity": "accelerometer bias"}], "solution": solution}
    assert not_looked_at(document).startswith("not looked at: the gyroscopes")
    assert not_looked_at(document | {"error": [{"quantity": "gyroscope bias"}]}) == ""
    assert not_looked_at(document | {"solution": {"gyroscope": {}}}) == ""
    assert not_looked_at({"error": []}) == ""
