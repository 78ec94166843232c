"""A small solution with round numbers, and what a calibration says beside it."""

from datetime import UTC, datetime

import numpy as np

from fixtures_db.calibration import CalibrationFacts
from procedures.solution import Estimate, FitQuality, Solution, TriadCalibration

NOON = datetime(2026, 3, 4, 12, 0, tzinfo=UTC)


def solution(bias: float = 1e-3) -> Solution:
    accelerometer = TriadCalibration(
        Estimate(np.array([1020.0, 1015.0, 1018.0]), np.full(3, 1e-3), "count/(g s)"),
        Estimate(np.eye(3), np.full((3, 3), 1e-6), "1"),
        Estimate(np.array([bias, 2e-3, 1e-3]), np.full(3, 8e-8), "g"),
    )
    return Solution(accelerometer, None, None, None, FitQuality(3.0, 3, 0.4), (), np.zeros((0, 0)), 23.0)


def facts(serial: str = "S1") -> CalibrationFacts:
    return CalibrationFacts(
        "FOG-3", serial, "fog-station 0.1.0", {"dwell_01.csv": "ab" * 32}, accepted_utc=NOON, valid_from=NOON
    )
