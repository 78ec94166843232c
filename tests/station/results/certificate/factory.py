"""A stored calibration with all that a certificate needs, and a laboratory that certifies it."""

from datetime import UTC, date, datetime
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.imu_models import Limit, set_limits
from fixtures_db.schema import CalibrationRow
from fixtures_db.stored_calibrations import CalibrationFacts, accept_calibration
from procedures.calibration.solution_values import Solution
from station.results.certificate.content import Certificate, content_of
from station.results.certificate.laboratory import Laboratory, read_laboratory
from station.results.certificate.rendering import render
from station.results.parameters_by_name import applied, parameters
from tests.paths import ROOT
from tests.station.results.report import factory

EXAMPLE = ROOT / "station/results/certificate/laboratory_example.toml"
NOON = datetime(2026, 3, 4, 12, 0, tzinfo=UTC)
LIMITS = (
    Limit("accelerometer.bias.x", -0.004, 0.004, "g", 1.64),
    Limit("gyroscope.bias.x", -2.0, 2.0, "deg/h", 1.64),
    Limit("gyroscope.scale_factor.x", 34000.0, None, "count/deg"),
    Limit("residual.p_value", 0.01, None, "1"),
)
REFERENCES: tuple[dict[str, Any], ...] = (
    {
        "kind": "cube", "id": "CUBE-7", "side_mm": 400.0, "certificate": "c1" * 32, "source": "CMM 12, lab Weber",
        "measured_utc": "2026-01-12T12:00:00Z", "due_date": "2027-01-12",
    },
    {
        "kind": "slab", "id": "SLAB-2", "certificate": "5a" * 32, "source": "electronic level 17, A. Weber",
        "measured_utc": "2026-02-01T12:00:00Z", "due_date": "2027-02-01",
    },
    {
        "kind": "site", "id": "LAB-1", "source": "gravimeter, survey 12", "measured_utc": "2024-05-01",
        "due_date": "2030-05-01",
    },
)  # fmt: skip
PROCEDURE = {
    "name": "twelve-position calibration on a level surface plate with 6 manual rotations of whole revolutions",
    "steps": [f"dwell_{p:02d}" for p in range(1, 13)]
    + [f"turn_{a}_{s}" for a in "xyz" for s in ("plus", "minus")],
    "started_utc": "2026-03-04T08:02:00Z",
    "ended_utc": "2026-03-04T10:41:00Z",
    "heading_std_deg": 0.05,
    "closure_std_deg": 0.01,
    "deviations": ["dwell_07 was recorded 2 times, the last one is used"],
}
SITE = {
    "id": "LAB-1", "latitude_deg": 48.1374, "height_m": 519.0, "gravity_m_s2": 9.8072914, "gravity_std_m_s2": 2e-7,
    "gravity_source": "gravimeter, survey 12",
}  # fmt: skip


def budget(document: dict[str, Any]) -> dict[str, Any]:
    """Return a budget/1 in which counting noise is a third of the variance and rests on 40 degrees of freedom."""
    entries = []
    for name, one in applied(parameters(document)).items():
        noise, std = float(one.std or 1e-6), 3**0.5 * float(one.std or 1e-6)
        dof = 40.0 / (1 / 3) ** 2
        k = 1.966
        entries.append({
            "name": name, "value": one.value, "unit": one.unit, "std": std, "dof": dof, "coverage_factor": k,
            "expanded": k * std,
            "contributions": [
                {"source": "counting noise", "type": "A", "std": noise, "dof": 40.0},
                {"source": "cube", "type": "B", "std": 2**0.5 * noise},
            ],
        })  # fmt: skip
    return {"format": "budget/1", "coverage": 0.95, "parameters": entries}


def accepted(session: Session, solution: Solution | None = None, **changes: Any) -> CalibrationRow:
    """Store a calibration that nothing is missing from, but for the ``changes``."""
    from fixtures_db.stored_calibrations import calibration_document

    solution = factory.solution() if solution is None else solution
    facts: dict[str, Any] = {
        "model": "FOG-3", "serial": "S0101", "software": "fog-station 0.1.0 (93474ad0c1de)",
        "inputs": {f"dwell_{p:02d}.mcap": f"{p * 7919:064x}" for p in range(1, 13)},
        "accepted_utc": NOON, "valid_from": NOON, "temperature_range_c": (22.9, 23.4), "operator": "M. Curie",
        "verdict": "PASS", "limits": LIMITS,
        "judged": ({"parameter": "residual.p_value", "verdict": "PASS", "value": 0.254, "unit": "1"},),
        "residual": {"p_value": 0.254, "chi2": 31.4, "dof": 27}, "procedure": PROCEDURE, "site": SITE,
        "references": REFERENCES,
    }  # fmt: skip
    facts |= {"uncertainty": budget(calibration_document(solution, CalibrationFacts(**facts), "0" * 64))} | changes
    if facts["verdict"] is not None:
        set_limits(session, facts["model"], facts["limits"])
    return accept_calibration(session, solution, CalibrationFacts(**facts))


def drifted(by_sigma: float) -> Solution:
    """Return the solution with the gyroscopes' biases moved."""
    from dataclasses import replace

    solution = factory.solution()
    assert solution.gyroscope is not None
    bias = solution.gyroscope.bias
    moved = replace(bias, value=bias.value + by_sigma * np.array([1.0, 0.1, -0.3]) * bias.std)
    return replace(solution, gyroscope=replace(solution.gyroscope, bias=moved))


def rendered(certificate: Certificate) -> str:
    """Return a certificate's HTML."""
    return render(content_of(certificate))


def laboratory() -> Laboratory:
    """Return the laboratory of the documentation, with what a customer's order adds."""
    lab = read_laboratory(EXAMPLE).given(
        "customer", {"name": "Sky AG", "address": "Am Flugplatz 3, 8600 Town", "email": "imu@sky.example"}
    )
    return lab.given("item", {"received": date(2026, 3, 2), "condition": "no damage seen, seals whole"})
