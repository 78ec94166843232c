"""What a reader is shown of a `diagnosis/2`: one number for each term, many findings of a term as one cause."""

from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest

from procedures.effects import EFFECTS
from procedures.inference.priors import word
from procedures.inference.result import Fault
from station.results.diagnosis.diagnosis_document import (
    STILL_IN,
    DiagnosisDocument,
    Table,
    channel_table,
    document_of,
)
from station.results.diagnosis.diagnosis_html import section_html
from station.results.diagnosis.diagnosis_text import diagnosis_text
from station.results.diagnosis.finding_wording import (
    MANY,
    OF_SAMPLES,
    amplitudes,
    meaning_of,
    probability_text,
    where_text,
)
from station.results.diagnosis.log_measurements import (
    AGAIN,
    REPETITIONS,
    Recorded,
    fitted_to,
    next_in_words,
    recording_of,
    wanted,
)
from station.results.diagnosis.next_measurements import write_plans


def finding(effect: str, probability: float, where: dict[str, Any] | None = None, **more: Any) -> dict[str, Any]:
    confidence = "established" if probability >= 0.99 else "likely" if probability >= 0.9 else "possible"
    return {
        "effect": effect, "kind": "instrument", "coefficients": {"z": {"value": 14.0, "std": 0.5}},
        "unit": "deg/h", "where": where or {}, "probability": probability, "confidence": confidence,
        "aliases": [], "separate_by": "", **more,
    }  # fmt: skip


def diagnosis(*findings: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {
        "format": "diagnosis/2", "recording": "rest", "verdict": "established", "log10_p": -0.3,
        "findings": list(findings), "error": [], "parameters": [], "next_measurement": "", "warnings": [], **more,
    }  # fmt: skip


DRIFT, WARM = "gyroscope.bias_drift", "gyroscope.bias_temperature"
AMBIGUOUS = diagnosis(
    finding(WARM, 0.6, aliases=[DRIFT], shares={WARM: 0.7, DRIFT: 0.31}, joint_probability=0.99),
    verdict="ambiguous",
    probabilities={WARM: 0.6, DRIFT: 0.37, "gyroscope.jump": 0.02},
)
SHOCKS = diagnosis(
    *(
        finding("disturbance.dwell", p, {"file": "log.csv", "channel": "ay", "from_s": 40.0 * i, "to_s": 41.0})
        for i, p in enumerate([0.999] * 40 + [0.93, 0.995], 1)
    )
)


def both(found: dict[str, Any]) -> tuple[str, str]:
    return diagnosis_text(found), section_html(found, None)


def test_a_term_has_one_probability_wherever_it_stands() -> None:
    for shown in both(AMBIGUOUS):
        assert "0.37" in shown
        assert "0.31" not in shown
    document = document_of(AMBIGUOUS)
    assert [row[0].split()[-1] for row in document.causes[0].rows(1)] == [WARM, DRIFT]
    assert [row[2] for row in document.causes[0].rows(1)] == ["0.60", "0.37"]
    assert document.cause_note
    [others] = [each for each in document.sections if isinstance(each, Table)]
    assert others.rows == (("gyroscope.jump", "0.02"),)  # no alternative once more


def test_the_likeliest_cause_is_first_and_one_without_a_name_stands_among_them() -> None:
    nameless = {
        "what": "a function of time",
        "note": "",
        "probability": 0.9,
        "joint_probability": 0.95,
        "shares": {},
    }
    found = diagnosis(finding(DRIFT, 0.92), finding(WARM, 0.99), unnamed=[nameless], verdict="partly")
    assert [each.effect for each in document_of(found).causes] == [WARM, "", DRIFT]


def test_many_findings_of_a_term_are_one_cause_with_number_first_and_last_time() -> None:
    [cause] = document_of(SHOCKS).causes
    for part in ("42 times", "first at 40 s", "last at 1680 s"):
        assert part in cause.about
    [occurrences] = cause.tables
    assert len(occurrences.rows) == 42
    assert cause.probability == "0.93 to 0.999"
    for shown in both(SHOCKS):
        assert "from_s" not in shown
        assert "to_s" not in shown


def test_faults_of_a_channel_are_one_cause_each_and_not_called_a_disturbance() -> None:
    spikes = [
        finding("disturbance.dwell", 0.999, {"file": "log.csv", "channel": "gx", "at_s": t}, fault="wrong row")
        for t in (200.0, 888.85, 1650.0)
    ]
    where = {"file": "log.csv", "channel": "gx", "from_s": 1000.0, "to_s": 1040.0}
    shown = document_of(diagnosis(*spikes, finding("disturbance.dwell", 0.9999, where, fault="frozen")))
    assert [len(cause.tables[0].rows) for cause in shown.causes] == [1, 3]
    assert not any(cause.equation for cause in shown.causes)
    assert "3 times" in shown.headline
    assert "disturbance while" not in shown.headline.lower()


def test_every_kind_of_finding_has_words_of_its_own() -> None:
    names = [*(each.name for each in EFFECTS), *OF_SAMPLES]
    found = [meaning_of(finding(name, 0.99)) for name in names]
    found += [meaning_of(finding("disturbance.dwell", 0.99, fault=fault)) for fault in get_args(Fault) if fault]
    found += [meaning_of(finding(e.name, 0.99, shape=shape)) for e in EFFECTS for shape in e.of_shape]
    assert all(found)
    assert len(set(found)) == len(found)


def test_the_surest_and_largest_cause_is_first_in_the_first_sentence() -> None:
    small, large = finding(DRIFT, 0.9999, share=0.02), finding(WARM, 0.995, share=0.9)
    unsure = finding("gyroscope.jump", 0.6, share=0.99)
    for verdict in ("ambiguous", "unexplained"):
        shown = document_of(diagnosis(unsure, small, large, verdict=verdict)).headline
        assert shown.index(WARM) < shown.index(DRIFT) < shown.index("gyroscope.jump")
    assert [cause.effect for cause in document_of(diagnosis(unsure, small, large)).causes][:2] == [WARM, DRIFT]


def test_a_periodic_error_has_an_amplitude() -> None:
    waves = {
        "gx.cos1": {"value": 3.0, "std": 0.1}, "gx.sin1": {"value": 4.0, "std": 0.1},
        "gx.cos2": {"value": 0.5, "std": 0.1}, "gx.sin2": {"value": 0.0, "std": 0.1},
    }  # fmt: skip
    found = finding("disturbance.line", 0.999) | {"coefficients": waves}
    first, second = amplitudes(found)
    assert (first.text, second.text) == ("gx amplitude 5.00 +- 0.10 deg/h", "gx harmonic 2 0.50 +- 0.10 deg/h")


def test_raw_channels_are_reported_to_hold_the_causes_that_were_found() -> None:
    assert STILL_IN in channel_table([channel()], [finding(WARM, 0.99)]).title
    assert STILL_IN not in channel_table([channel()]).title


def solved() -> dict[str, Any]:
    eye, u = np.eye(3), np.full((3, 3), 1e-5)
    u[0] = 0.0  # held by the choice of axes
    return {
        "accelerometer": {
            "scale_factor": {"value": [1.0, 1.1, 1.2], "std": [1e-4] * 3, "unit": "output/g"},
            "misalignment": {"value": eye.tolist(), "std": u.tolist(), "unit": "1"},
            "bias": {"value": [0.004, 0.0, 0.01], "std": [2e-5] * 3, "unit": "g"},
        }
    }


def test_a_calibration_is_in_text_and_page_each_quantity_in_one_unit() -> None:
    found = diagnosis(recording="rests", verdict="consistent", solution=solved())
    for shown in both(found):
        for part in ("4000", "misalignment zx", "1.2000", "arcsec"):
            assert part in shown
        assert "misalignment xy" not in shown
        assert "gyroscope" in shown  # not solved
    assert "misalignment" not in diagnosis_text(found | {"recording": "campaign"})


def test_few_findings_of_a_term_stand_each_for_itself() -> None:
    found = diagnosis(*SHOCKS["findings"][:MANY])
    assert len(document_of(found).causes) == MANY


@pytest.mark.parametrize("p", [0.89999, 0.9, 0.98995, 0.9899999, 0.99])
def test_a_probability_is_shown_on_its_side_of_the_limit_of_a_word(p: float) -> None:
    assert word(float(probability_text(p))) == word(p)


@pytest.mark.parametrize("p", [0.0, 1e-9, 0.5, 0.9999, 1.0])
def test_no_probability_is_zero_or_one(p: float) -> None:
    text = probability_text(p)
    assert text.startswith(("<", ">")) or 0 < float(text) < 1


def test_the_first_sentence_has_sensor_size_and_time() -> None:
    found = diagnosis(finding("gyroscope.jump", 0.995, {"in": "log.csv", "after_s": 2000.0}))
    for part in ("z 14.00 +- 0.50 deg/h", "2000 s", "log.csv", "0.995"):
        assert part in document_of(found).headline


def test_a_place_names_no_key() -> None:
    where = {"file": "a.csv", "channel": "ay", "from_s": 1.5, "to_s": 2.0, "position": [3, 4], "others": 6}
    text = where_text(where)
    assert "_s" not in text
    for part in ("1.5 s", "2 s", "a.csv", "3 or 4", "7"):
        assert part in text


def channel(**more: Any) -> dict[str, Any]:
    line = {"value": 1.0, "std": 0.1, "unit": "deg/h/h"}
    return {
        "channel": "gyroscope z",
        "recording": "a.csv",
        "seconds": 9.0,
        "drift": line,
        "by_temperature": line,
    } | more


@pytest.mark.parametrize(
    ("is_confounded", "found", "is_reported"),
    [
        (True, [], True),
        (False, [], False),
        (True, [finding(WARM, 0.99)], False),
        (True, [finding(WARM, 0.6)], True),
    ],
)
def test_drift_and_temperature_are_inseparable_only_where_no_finding_separates_them(
    is_confounded: bool, found: list[dict[str, Any]], is_reported: bool
) -> None:
    channels = [channel(**({"is_confounded": True} if is_confounded else {}))]
    assert bool(channel_table(channels, found, has_noise=True).note) is is_reported


def loaded(**steps: Any) -> Any:
    kinds = dict.fromkeys(("dwells", "rests", "sequences", "moves", "turns", "soaks", "rate_tables"), ())
    return SimpleNamespace(campaign=SimpleNamespace(**kinds | steps))


@pytest.mark.parametrize(
    ("step", "recording"),
    [
        ("dwells", "campaign"),
        ("sequences", "rests"),
        ("turns", "rotation"),
        ("soaks", "rest"),
        ("rate_tables", "rate table"),
    ],
)
def test_the_kind_of_a_recording(step: str, recording: str) -> None:
    assert recording_of([loaded(**{step: (1,)})]) == recording


@pytest.mark.parametrize("recording", REPETITIONS)
def test_outside_a_campaign_nothing_asks_for_positions_of_a_cube(recording: Any, tmp_path: Any) -> None:
    recorded = Recorded(recording, "recorded")
    findings = [fitted_to(recorded, finding(each.name, 0.5)) for each in EFFECTS]
    assert all(each["separate_by"] for each in findings)
    document = diagnosis(*findings, recording=recording, next_measurement="something")
    every = [*wanted(document, []), AGAIN[recording]]
    steps = [step for one in every for of_kind in one.steps.values() for step in of_kind]
    assert not any("position" in step for step in steps)
    assert bool(steps) is (recording != "rate table")
    assert all(path.read_text() for path in write_plans(tmp_path / "next.toml", every))


def at_rest(*temperature: float) -> Any:
    return loaded(soaks=(SimpleNamespace(series=SimpleNamespace(temperature=np.array(temperature))),))


@pytest.mark.parametrize(
    ("temperature", "asked", "is_named"),
    [((np.nan, np.nan), "another day", False), ((20.0, 21.0), "heated by 15 K", True),
     ((20.0, 40.0, 20.0), "half the rate", True)],
)  # fmt: skip
@pytest.mark.parametrize("p", [0.5, 0.97])
def test_the_next_measurement_is_the_one_that_the_plan_has(
    temperature: tuple[float, ...], asked: str, is_named: bool, p: float
) -> None:
    """A heated rest is no news after a heating cycle, and none is asked for where no temperature is recorded."""
    campaigns = [at_rest(*temperature)]
    recorded = Recorded.of(campaigns)
    findings = [fitted_to(recorded, finding("gyroscope.bias_drift", p))]
    reported = next_in_words(recorded, findings, "needed")
    document = diagnosis(*findings, recording="rest", next_measurement=reported)
    assert "; ".join(one.phrase for one in wanted(document, campaigns)) == reported
    if p < 0.9:
        assert asked in reported
        assert ("heated" in reported) is is_named


def test_the_document_of_a_bare_verdict_is_its_headline() -> None:
    found = document_of(diagnosis(verdict="consistent"))
    assert found == DiagnosisDocument(
        verdict="consistent", title="consistent", headline=found.headline, causes=(), cause_note="",
        not_separable=(), measure_next="", plan_hint="", searched="", sections=(), noise=(), not_observable="",
        warnings=(),
    )  # fmt: skip
