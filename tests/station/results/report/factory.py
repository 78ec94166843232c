"""A made-up solution and campaign with the shape of a real one."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from procedures.calibration.solution_values import Estimate, FitQuality, Solution, StepResidual, TriadCalibration
from procedures.campaign.campaign import Campaign, DwellRecord, FaceCertificate, Fixture, Site, TurnRecord
from procedures.counts.sample_records import CountSeries
from procedures.frames import AXES
from procedures.positions import POSITIONS
from procedures.uncertainty.budget import ParameterBudget, combined_budget
from procedures.uncertainty.sources import SourceCell
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.report.report import CalibrationReport, calibration_report
from station.results.solution_json import Provenance, SolutionDocument, solution_document
from station.results.verdict import LimitVerdict

K_ACCELEROMETER = np.array([1020.0, 1015.0, 1018.0])
K_GYROSCOPE = np.array([36147.26, 35780.61, 35709.35])
E = np.array([[0.999995, 0.001, 0.003], [0.002, 0.9999975, 0.001], [-0.003, 0.002, 0.9999935]])
E_STD = np.where(np.eye(3) == 1, 2.1e-8, np.array([[1, 6.2e-6, 7.1e-6], [5.9e-6, 1, 6.6e-6], [6.4e-6, 6.0e-6, 1]]))


def _triad(k: np.ndarray, unit: str, bias: np.ndarray, bias_std: float, bias_unit: str) -> TriadCalibration:
    steps = np.array([0.3, -0.9, 1.4])
    joint = Estimate(bias + steps * bias_std, np.full(3, bias_std) * [1.0, 1.1, 0.93], bias_unit)
    twelve = replace(joint, value=bias + 1e-4 * np.abs(bias).max() * np.array([1.67, 0.67, 1.0]))
    return TriadCalibration(
        Estimate(k * (1 + 1.1e-6 * steps), k * 1.3e-6, unit),
        Estimate(E + 0.4 * E_STD, E_STD, "1"),
        joint,
        twelve,
        twelve,
    )


def _residuals(rng: np.random.Generator) -> list[StepResidual]:
    found = []
    for triad, sigma, unit in (("accelerometer", 1.1e-7, "g"), ("gyroscope", 0.021, "deg/h")):
        for position in range(1, 13):
            std = sigma * rng.uniform(0.8, 1.3, 3)
            name = f"dwell_{position:02d}.csv"
            found.append(StepResidual(name, "dwell", triad, position, std * rng.normal(size=3), std, unit))
    for axis, position in zip(AXES, (1, 5, 9), strict=True):
        for word in ("plus", "minus"):
            std = np.full(3, 0.012)
            name = f"turn_{axis}_{word}.csv"
            found.append(StepResidual(name, "turn", "gyroscope", position, std * rng.normal(size=3), std, "deg"))
    found[7] = replace(found[7], residual=found[7].sigma * [0.4, 4.6, -2.2])
    return found


def solution(seed: int = 1) -> Solution:
    rng = np.random.default_rng(seed)
    triads = ("accelerometer", "gyroscope")
    names = tuple(f"{t}.{what}.{axis}" for t in triads for what in ("scale_factor", "bias") for axis in AXES)
    mixing = rng.normal(size=(len(names), len(names)))
    return Solution(
        accelerometer=_triad(K_ACCELEROMETER, "count/(g s)", np.array([1e-3, 2e-3, -1e-3]), 0.81e-7, "g"),
        gyroscope=_triad(K_GYROSCOPE, "count/deg", np.array([0.80, 0.89, -0.41]), 0.0098, "deg/h"),
        slab_tilt=Estimate(np.array([5.1e-5, -4.9e-5]), np.full(2, 3.1e-8), "rad"),
        parallelism=Estimate(np.array([[1, 3], [5, 3], [5, 3]]) * 1e-4, np.full((3, 2), 1.4e-7), "rad"),
        quality=FitQuality(31.4, 27, 0.254, 1.02e-7, 0.0193),
        names=names,
        covariance=mixing @ mixing.T,
        reference_temperature=23.04,
        residuals=tuple(_residuals(rng)),
        not_observable=("accelerometer.misalignment against fixture.perpendicularity: 6 combinations",),
        warnings=("dwell_07.csv:2501: gap of 0.4 s at t = 1018.2 s; two segments share one rate",),
        unused_steps=("soak (soak_01.csv)",),
    )


def _series(rng: np.random.Generator, start: float, samples: int) -> CountSeries:
    period = 0.02
    gyro = rng.normal(0.1, 2.0, (samples, 3))
    accel = rng.normal(0.3, 0.9, (samples, 3))
    t = start + period * np.arange(1, samples + 1)
    counts = [np.diff(np.floor(np.cumsum(x, axis=0)), axis=0, prepend=0.0).astype(np.int64) for x in (gyro, accel)]
    return CountSeries(t, counts[0], counts[1], 23.0 + 1e-4 * t, period)


def campaign(seed: int = 1, serial: str = "S0101", model: str = "FOG-3", samples: int = 5000) -> Campaign:
    rng = np.random.default_rng(seed)
    dwells = tuple(
        DwellRecord(f"dwell_{p:02d}.csv", p, _series(rng, 145.0 * p, samples))
        for p in range(1, len(POSITIONS) + 1)
    )
    turn = TurnRecord("turn_x_plus.csv", "x", "+", 3, 1, _series(rng, 4000.0, 100))
    faces = {"x_up": FaceCertificate(np.array([1e-5, -2e-5]), np.eye(2) * 25e-12)}
    site = Site(np.radians(31.17), 9.7946, 1e-5)
    return Campaign(model, serial, True, site, dwells, (turn,), fixture=Fixture(faces, id="CUBE-7"))


def budgets() -> tuple[ParameterBudget, ...]:
    parts = {
        SourceCell("counting noise", dof=240.0): 4.9e-15,
        SourceCell("bias instability", dof=6.0): 9e-16,
        SourceCell("cube"): 8e-18,
    }
    bias = [
        combined_budget(f"accelerometer.bias.{axis}", v, "g", parts)
        for axis, v in zip(AXES, (1e-3, 2e-3, -1e-3), strict=True)
    ]
    closure = {SourceCell("closure"): 0.22, SourceCell("counting noise", dof=3e4): 1e-3}
    return (*bias, combined_budget("gyroscope.scale_factor.x", 36147.26, "count/deg", closure))


def truth() -> dict[str, float]:
    values = {}
    for name, k, bias in (
        ("accelerometer", K_ACCELEROMETER, [1e-3, 2e-3, -1e-3]),
        ("gyroscope", K_GYROSCOPE, [0.80, 0.89, -0.41]),
    ):
        for i, axis in enumerate(AXES):
            values[f"{name}.scale_factor.{axis}"] = float(k[i])
            values[f"{name}.bias.{axis}"] = float(bias[i])
            for j, body in enumerate(AXES):
                values[f"{name}.misalignment.{axis}{body}"] = float(E[i, j])
    return values | {"slab.tilt.east": 5.1e-5, "slab.tilt.north": -4.9e-5}


def document(
    solved: Solution, measured: Campaign, files: dict[str, str] | None = None,
    software: str = "fog-station 0.1.0 (081380b)",
) -> SolutionDocument:  # fmt: skip
    """Return solution/1 with a time of its own."""
    tables = CampaignTable.model_validate(
        {
            "format": "campaign/1",
            "imu": {"model": "M", "serial": "S", "sample_period_s": 0.02, "output": "increments"},
            "site": {"latitude_deg": 1},
        }
    )
    made = solution_document(solved, [LoadedCampaign(Path("c"), tables, measured, (), FILES, (), ())])
    origin = Provenance(files or FILES, measured.model, measured.serial, software, "2026-03-04 12:00 UTC")
    return replace(made, provenance=origin)


FILES = {f"dwell_{p:02d}.csv": f"{p * 7919:064x}" for p in range(1, 13)} | {"campaign.toml": "5f" * 32}
VERDICT = LimitVerdict("PASS", (), "all 24 parameters within the limits of FOG-3")


def report(
    solved: Solution | None = None, measured: Campaign | None = None, *, made_of: SolutionDocument | None = None,
    **more: Any,
) -> CalibrationReport:  # fmt: skip
    solved, measured = solved or solution(), measured or campaign()
    more = {"verdict": VERDICT, "bench": {"Cube certificate": "CMM 2026-01-12, due 2027-01-12"}} | more
    made = calibration_report(solved, [measured], made_of or document(solved, measured), **more)
    return replace(made, calibration_sha256="c0ffee" + "0" * 58)
