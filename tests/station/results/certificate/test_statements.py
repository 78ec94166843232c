"""Statements of a certificate: conformity, what the model lacks, what is missing, in German too."""

import math
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from fixtures_db.database import open_db
from fixtures_db.imu_models import Limit
from procedures.inference.result import Verdict
from procedures.twelve_positions.bench_parameters import SLAB_TILT_RANGE_RAD
from procedures.uncertainty.sources import SOURCES
from station.errors import DataRefused
from station.results.certificate.conformity import LimitComparison, conformity, greatest_risk, printed
from station.results.certificate.dcc.names import SOURCE_NAMES, VERDICTS, in_german, parameter_name
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.missing_statements import (
    FROM_CALIBRATION,
    FROM_LABORATORY,
    check_received,
    missing,
)
from station.results.certificate.model_statement import (
    SLAB_RANGE_DEG,
    diagnosis_in_words,
    residual_in_words,
    stated,
    taken_as_zero,
)
from station.results.certificate.printed_results import MEANINGS, MeasuredParameter
from tests.station.results.certificate.dcc_kinds import KINDS, of_kind

LIMIT = Limit("gyroscope.bias.x", -1.0, 1.0, "deg/h", 1.64)


@pytest.mark.parametrize("dof", [4.0, math.inf])
@pytest.mark.parametrize("value", [-0.9, 0.0, 0.7, 1.2])
def test_the_risk_is_the_share_of_true_values_beyond_the_limits(dof: float, value: float) -> None:
    rng, n, std = np.random.default_rng(1), 200_000, 0.3
    spread = rng.standard_normal(n) if math.isinf(dof) else rng.standard_t(dof, n)
    share = float(np.mean(np.abs(value + std * spread) > 1.0))
    risk = LimitComparison(LIMIT, value, std, dof, "PASS").risk
    assert risk is not None
    assert abs(risk - share) < 4 * math.sqrt(max(risk * (1 - risk), 1e-6) / n)


@pytest.mark.parametrize(("guard", "percent"), [(0.0, 50.0), (1.64, 5.05), (2.0, 2.28)])
def test_the_greatest_risk_is_the_normal_tail(guard: float, percent: float) -> None:
    assert abs(100 * greatest_risk(guard) - percent) < 0.01


@pytest.mark.parametrize(("value", "word"), [(0.83, "PASS"), (0.84, "FAIL"), (-0.84, "FAIL"), (1.1, "FAIL")])
def test_a_value_is_accepted_within_the_tolerance_less_the_guard_band(value: float, word: str) -> None:
    document = {
        "limits": [{"parameter": LIMIT.parameter, "low": -1.0, "high": 1.0, "unit": "deg/h", "guard_band": 1.64}],
        "verdict": "PASS",
    }
    result = MeasuredParameter(LIMIT.parameter, value, "deg/h", 0.1, math.inf, 1.96, 0.196, ())
    found = conformity(document, {LIMIT.parameter: result})  # w = 1.64 * 0.1, by the combined u, not the solve's
    assert found is not None
    assert (found.word, found.stored) == (word, "PASS")
    [(*_, guard, bar, _, _)] = printed(found.against)
    assert guard.strip() == "0.16"
    assert bar == (pytest.approx(value), pytest.approx(0.164))


def test_what_was_judged_then_is_judged_now_and_what_has_no_value_is_not_measured() -> None:
    limits = [
        {"parameter": "residual.p_value", "low": 0.01, "unit": "1", "guard_band": 0.0},
        {"parameter": "slab.tilt.east", "low": -1e-4, "high": 1e-4, "unit": "rad", "guard_band": 2.0},
    ]
    judged = [{"parameter": "residual.p_value", "verdict": "PASS", "value": 0.2, "unit": "1"}]
    found = conformity({"limits": limits, "judged": judged}, {})
    assert found is not None
    assert [one.word for one in found.against] == ["PASS", "NOT_MEASURED"]
    assert found.word == "NOT_MEASURED"
    assert conformity({}, {}) is None


QUADRATIC = {"effect": "accelerometer.quadratic", "confidence": "possible", "aliases": ["fixture.parallelism"]}
WARNING = "the residual is larger (chi-square 90 at 30): the uncertainties are too small; run `station diagnose`"
K2 = "accelerometer.quadratic"


def budget(source: str) -> dict[str, Any]:
    part = {"source": source, "type": "B", "std": 2e-3}
    return {"parameters": [{"name": "accelerometer.scale_factor.x", "value": 100.0, "contributions": [part]}]}


def test_what_a_campaign_cannot_distinguish_is_reported() -> None:
    reported = diagnosis_in_words({"diagnosis": {"verdict": "ambiguous", "findings": [QUADRATIC]}})
    expected = "Not separated by this campaign: quadratic term of the accelerometers (K2) or cube parallelism."
    assert reported == ["Diagnosis of the residual: ambiguous.", expected]
    assert (
        "consistent with noise" in diagnosis_in_words({"diagnosis": {"verdict": "consistent", "findings": []}})[1]
    )
    assert (
        "no known error term" in diagnosis_in_words({"diagnosis": {"verdict": "unexplained", "findings": []}})[1]
    )
    assert diagnosis_in_words({}) == ["No diagnosis of the residual is stored with this calibration."]


def test_what_is_taken_as_zero_is_reported_once_and_not_if_carried() -> None:
    document: dict[str, Any] = {"procedure": {}, "accelerometer": {}}
    assert taken_as_zero(document) == [K2, "accelerometer.scale_asymmetry"]
    assert taken_as_zero({**document, "effects": [{"name": K2}]}) == ["accelerometer.scale_asymmetry"]
    steps = {"not_observable": [f"{K2} (with accelerometer.bias)"]}
    assert taken_as_zero({**document, "procedure": steps})[1:] == ["accelerometer.scale_asymmetry"]


@pytest.mark.parametrize("source", ["unexplained", "cube"])
def test_a_warning_to_the_operator_is_not_printed_to_the_customer(source: str) -> None:
    reported = residual_in_words({"uncertainty": budget(source)}, WARNING)
    assert reported.startswith("the residual is larger (chi-square 90 at 30)")
    assert "station diagnose" not in reported
    assert reported.endswith("is included in U") == (source == "unexplained")
    assert (
        residual_in_words({}, "gyroscope not solved: no turn about x") == "gyroscope not solved: no turn about x"
    )


def test_what_is_stated_has_its_value() -> None:
    lines = dict(stated({"procedure": {"heading_std_deg": 0.05}, "uncertainty": budget("clock")}))
    assert lines["Heading of a position"] == "u = 0.05\u00b0"
    assert "relative u = 2e-05, a stated value" in lines["Time base"]
    assert np.isclose(np.degrees(SLAB_TILT_RANGE_RAD), SLAB_RANGE_DEG, rtol=0.02)


def laboratory(**tables: Any) -> Laboratory:
    return Laboratory.model_validate({"format": "laboratory/1", **tables})


def test_of_nothing_all_is_missing_each_with_where_it_is_given() -> None:
    assert missing({}, laboratory()) == [*FROM_CALIBRATION.items(), *FROM_LABORATORY.items()]


@pytest.mark.parametrize(
    ("received", "reported"),
    [
        (date(2026, 3, 4), ""),
        (date(2026, 3, 5), "2026-03-04"),
        (date(2026, 3, 8), "2026-03-07"),
        (None, ""),
    ],
)
def test_a_unit_is_received_before_it_is_measured(received: date | None, reported: str) -> None:
    stated = laboratory(item={"received": received}) if received else laboratory()
    document = {"procedure": {"started_utc": "2026-03-04T08:00:00+00:00"}}
    now = datetime(2026, 3, 7, 12, tzinfo=UTC)
    if not reported:
        check_received(document, stated, now)
        return
    with pytest.raises(DataRefused, match=reported):
        check_received(document, stated, now)


@pytest.mark.parametrize(
    ("english", "german"),
    [
        ("twelve-position calibration on a level surface plate with 6 manual rotations of whole "
         "revolutions and 2 recordings in free positions",
         "Kalibrierung in zwölf Lagen auf der Richtplatte mit 6 Drehungen von Hand um ganze Umdrehungen und "
         "2 Aufzeichnungen in freien Lagen"),
        ("dwell_07 was recorded 2 times, the last one is used",
         "dwell_07 wurde 2 mal aufgezeichnet, die letzte gilt"),
        ("warm-up was skipped: biases may drift by 0.2 deg/h and 30 ug (standard uncertainty)",
         "das Einlaufen wurde ausgelassen: Nullpunkte können um 0.2 deg/h und 30 ug wandern "
         "(Standardunsicherheit)"),
        ("Diagnosis of the residual: established.", "Diagnose des Residuums: Ursache gesichert."),
        ("Not separated by this campaign: cube parallelism or slab.",
         "Von dieser Kampagne nicht unterschieden (englisch): cube parallelism or slab."),
        ("the certificate of cube C-7 expired on 2026-03-03", "der Schein von Würfel C-7 lief am 2026-03-03 ab"),
        ("Time base: the device\u2019s own clock; rate assumed correct, relative u = 1e-05, a stated value; "
         "not compared with a reference here",
         "Zeitbasis: die Uhr des Geräts; Gang als richtig angenommen, relativ u = 1e-05, ein Angabewert; "
         "hier mit keinem Normal verglichen"),
    ],
)  # fmt: skip
def test_a_sentence_is_worded_in_german(english: str, german: str) -> None:
    assert in_german(english) == german


def test_every_verdict_has_a_german_word() -> None:
    assert set(VERDICTS) == set(get_args(Verdict))


def test_every_source_has_a_german_name_and_a_meaning() -> None:
    assert set(SOURCE_NAMES) == set(SOURCES) == set(MEANINGS)
    assert parameter_name("gyroscope.misalignment.xy").de == "Kreisel, Fehlausrichtung xy"


@pytest.mark.parametrize("kind", ["twelve positions", "expired", "simulated"])
def test_what_a_certificate_says_of_itself_is_known(tmp_path: Path, kind: str) -> None:
    assert kind in KINDS
    with open_db(tmp_path / "station.db") as database, database.write() as session:
        content = of_kind(session, kind)
    reported = [*content.deviations, *content.diagnosis, *(f"{label}: {text}" for label, text in content.stated)]
    reported += [*content.certificate.reasons, str(content.document["procedure"]["name"])]
    assert [text for text in reported if in_german(text) is None] == []
