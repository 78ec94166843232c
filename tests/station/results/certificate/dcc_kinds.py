"""Calibrations of every kind that a certificate can be of, and what is said of each."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sqlalchemy.orm import Session

from procedures.calibration.solution_values import Solution
from station.results.certificate.content import Certificate, CertificateContent, ReplacedCertificate, content_of
from tests.station.results.certificate.factory import NOON, REFERENCES, accepted, drifted, laboratory
from tests.station.results.report import factory

EFFECTS = (
    {"name": "accelerometer.quadratic", "coefficients": {"x": {"value": 1.23e-6, "std": 2e-8}}, "unit": "g/g^2"},
    {
        "name": "gyroscope.bias_temperature", "unit": "deg/h/K", "reference": {"temperature_c": 23.0},
        "coefficients": {"x": {"value": -0.012, "std": 0.003}, "z": {"value": 0.004, "std": 0.003}},
    },
    {"name": "own.odd", "coefficients": {"c": {"value": 0.5, "std": 0.1}}, "unit": "ax..az: g/unit",
     "sha256": "ef" * 32},
)  # fmt: skip


def _rates() -> Solution:
    solution = factory.solution()
    assert solution.accelerometer is not None
    assert solution.gyroscope is not None
    units = {"accelerometer": "output/g", "gyroscope": "output/(deg/s)"}
    triads = {
        name: replace(triad, scale_factor=replace(triad.scale_factor, unit=units[name]))
        for name, triad in (("accelerometer", solution.accelerometer), ("gyroscope", solution.gyroscope))
    }
    return replace(solution, **triads)


def _procedure(name: str, steps: list[str]) -> dict[str, Any]:
    from tests.station.results.certificate.factory import PROCEDURE

    return {"procedure": {**PROCEDURE, "name": name, "steps": steps}}


KINDS: dict[str, Callable[[Session], Any]] = {
    "twelve positions": accepted,
    "six faces": lambda session: accepted(
        session, **_procedure("calibration from 6 of 12 positions on a level surface plate", ["dwell_01"])
    ),
    "free positions": lambda session: accepted(
        session, **_procedure("calibration with 30 recordings in free positions", ["rest_01", "rest_02"])
    ),
    "rates": lambda session: accepted(session, _rates(), limits=(), judged=()),
    "accelerometers alone": lambda session: accepted(session, replace(factory.solution(), gyroscope=None)),
    "gyroscopes alone": lambda session: accepted(session, replace(factory.solution(), accelerometer=None)),
    "effects": lambda session: accepted(session, effects=EFFECTS),
    "failed": lambda session: accepted(session, drifted(500.0), verdict="FAIL"),
    "no limits": lambda session: accepted(session, limits=(), judged=(), verdict=None),
    "expired": lambda session: accepted(
        session, references=({**REFERENCES[0], "due_date": "2026-03-03"}, *REFERENCES[1:])
    ),
    "no covariance": lambda session: accepted(session, replace(factory.solution(), names=())),
    "simulated": lambda session: accepted(session, model="SIM-FOG3"),
}


def content(document: dict[str, Any], **changes: Any) -> CertificateContent:
    """Return what a certificate of a calibration says."""
    return content_of(
        replace(Certificate("EX-2026-0001", NOON, document, "c0ffee" * 10 + "0000", laboratory()), **changes)
    )


def of_kind(session: Session, kind: str) -> CertificateContent:
    """Return what the certificate of a kind says: an amended one, of a unit that was calibrated before."""
    before = json.loads(accepted(session, drifted(2.0)).document)
    document = json.loads(KINDS[kind](session).document)
    replaced = ReplacedCertificate("EX-2026-0000", NOON, "ab" * 32, "wrong address", ("Customer",))
    return content(document, previous=before, previous_sha256="d0" * 32, replaced=replaced)
