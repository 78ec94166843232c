"""Sentences that the station stores with a calibration stand in German too."""

from pathlib import Path
from typing import get_args

import pytest

from fixtures_db.database import open_db
from procedures.diagnosis.result import Verdict
from procedures.uncertainty.sources import SOURCES
from station.results.certificate.dcc.german import VERDICTS, in_german
from station.results.certificate.dcc.names import SOURCE_NAMES, as_written, parameter_name
from station.results.certificate.source_meanings import MEANINGS
from tests.station.results.certificate.dcc_kinds import KINDS, of_kind


@pytest.mark.parametrize(
    ("english", "german"),
    [
        ("twelve-position calibration on a level slab with 6 hand turns of whole revolutions and 2 recordings in "
         "free positions", "Kalibrierung in zwölf Lagen auf der Richtplatte mit 6 Drehungen von Hand um ganze "
         "Umdrehungen und 2 Aufzeichnungen in freien Lagen"),
        ("dwell_07 was recorded 2 times, the last one is used",
         "dwell_07 wurde 2 mal aufgezeichnet, die letzte gilt"),
        ("warm-up was skipped: biases may drift by 0.2 deg/h and 30 ug (1 sigma)",
         "das Einlaufen wurde ausgelassen: Nullpunkte können um 0.2 deg/h und 30 ug wandern (1 Sigma)"),
        ("Diagnosis of the residual: established.", "Diagnose des Residuums: Ursache gesichert."),
        ("Not told apart by this campaign: cube parallelism or slab.",
         "Von dieser Kampagne nicht unterschieden (englisch): cube parallelism or slab."),
        ("the certificate of cube C-7 expired on 2026-03-03", "der Schein von Würfel C-7 lief am 2026-03-03 ab"),
        ("Time base: the device\u2019s own clock; rate taken as right within 1\u03c3 1e-05, a stated value; "
         "not compared with a reference here", "Zeitbasis: die Uhr des Geräts; Gang als richtig angenommen auf "
         "1\u03c3 1e-05, ein Angabewert; hier mit keinem Normal verglichen"),
    ],
)  # fmt: skip
def test_a_sentence_is_said_in_german(english: str, german: str) -> None:
    assert in_german(english) == german


@pytest.mark.parametrize("text", ["", "something else", "dwell_07 was recorded 2 times with care"])
def test_one_that_is_not_known_is_marked(text: str) -> None:
    assert in_german(text) is None
    assert as_written(text).de == f"(englisch) {text}"


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
    said = [*content.deviations, *content.diagnosis, *(f"{label}: {text}" for label, text in content.stated)]
    said += [*content.certificate.reasons, str(content.document["procedure"]["name"])]
    assert [text for text in said if in_german(text) is None] == []
