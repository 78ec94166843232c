"""Fleets with a known off unit and off cube, as the database hands them out."""

from datetime import UTC, datetime, timedelta

import numpy as np

from fixtures_db.hash_chain import GENESIS
from fixtures_db.stored_calibrations import CalibrationFacts, Run, calibration_document
from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, FitQuality, Solution, TriadCalibration

MODEL = "FOG-3"
BEGIN = datetime(2022, 1, 3, 12, tzinfo=UTC)
STD = {"count/(g s)": 1e-3, "count/deg": 3.6e-3, "1": 1e-6, "g": 1e-6, "deg/h": 1e-3}


def solution(rng: np.random.Generator, bias_ug: FloatArray) -> Solution:
    """Return both triads, their numbers scattered by their own sigmas, with this accelerometer bias (3,)."""

    def estimate(value: FloatArray, unit: str) -> Estimate:
        std = np.full(value.shape, STD[unit])
        return Estimate(value + std * rng.standard_normal(value.shape), std, unit)

    triads = [
        TriadCalibration(
            estimate(np.array([scale, scale, scale]), scale_unit), estimate(np.eye(3), "1"), estimate(bias, unit)
        )
        for scale, scale_unit, bias, unit in (
            (1020.0, "count/(g s)", bias_ug * 1e-6, "g"),
            (3600.0, "count/deg", np.full(3, 0.05), "deg/h"),
        )
    ]
    return Solution(*triads, None, None, FitQuality(3.0, 3, 0.4), (), np.zeros((0, 0)), 23.0)


def facts(serial: str, ended: datetime, recording: str, cube: str) -> CalibrationFacts:
    return CalibrationFacts(
        MODEL, serial, "fog-station 0.1.0", {"dwell_01.csv": recording}, ended, ended,
        valid_until=ended + timedelta(days=365), operator="A. Miller", references=({"kind": "cube", "id": cube},),
    )  # fmt: skip


def fleet(
    rng: np.random.Generator, units: int = 8, each: int = 4, off_cube_ug: float = 0.0, off_unit_ug: float = 0.0
) -> list[Run]:
    """Return units that scatter and walk; S2 may be off, and what CUBE-2 measures."""
    runs = list[Run]()
    for unit in range(units):
        ended, bias = BEGIN, 100.0 * rng.standard_normal(3) + off_unit_ug * (unit == 2)
        for i in range(each):
            ended += timedelta(days=int(rng.integers(100, 300)))
            bias = bias + 5.0 * rng.standard_normal(3)
            cube = f"CUBE-{1 + (i + unit) % 3}"
            measured = bias + 10.0 * rng.standard_normal(3) + off_cube_ug * (cube == "CUBE-2")
            runs.append(run(f"S{unit}", ended, f"{unit} {i}", cube, solution(rng, measured)))
    return runs


def run(serial: str, ended: datetime, recording: str, cube: str, found: Solution) -> Run:
    document = calibration_document(found, facts(serial, ended, recording, cube), GENESIS)
    made_with = {"cube": cube, "operator": "A. Miller"}
    return Run(f"{recording} {serial}", MODEL, serial, ended, recording, made_with, document)
