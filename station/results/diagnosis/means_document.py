"""The calibration by a table of means as a `means/2` document: verdict, wrong poses, values."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from procedures.anomalies.held_out_rows import WrongRow
from procedures.anomalies.wrong_poses import find_wrong_poses
from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.pose_tables import PoseDiagnosis, PoseTable, diagnose_poses
from procedures.errors import NotObservable
from procedures.frames import AXES
from procedures.free_positions.norm_fit import Undetermined
from procedures.free_positions.pose_means import MeansCalibration, calibrate_means, gyro_bias
from procedures.inference.priors import PRESENT, word
from procedures.inference.result import UNEXPLAINED_LOG_P, Verdict
from procedures.statistics.significance import log_chi2_sf
from procedures.units import STANDARD_GRAVITY
from station.files.campaign_folder.campaign_reading import ANY_EARTH_RATE_DEG_H, site_of
from station.files.campaign_folder.campaign_schema import SiteTable
from station.files.logs.means_table import MeansTable
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, RAW, outputs_per_unit
from station.results.diagnosis.diagnosis_json import (
    error_document,
    finding_document,
    probabilities_document,
    unnamed_document,
)
from station.results.result_formats import document_of
from station.results.solution_json import provenance_of
from station.text import NOT_KNOWN

LEAST_FREE = 0.5  # degrees of freedom, below which no residual is left to judge the poses by
FEW_FREE = 4.0  # degrees of freedom, below which a sigma from the scatter is itself known to no better than 35 %
MG = 1e3
POSES_LEFT_OUT = "pose, held out in turn"


def means_document(means: MeansTable, latitude_deg: float | None, serial: str | None) -> dict[str, Any]:
    """Return what a table of means says.

    Raises
    ------
    NotObservable
        If its poses determine no accelerometer, and there is no gyroscope either.
    """
    table = means.found.table
    site = site_of(None if latitude_deg is None else SiteTable(latitude_deg=latitude_deg))
    document: dict[str, Any] = {
        "format": "means/2", "file": table.file.name, "poses": len(means.rows), "verdict": "consistent",
        "wrong_poses": [], "findings": [], "unnamed": [], "error": [], "next_measurement": "",
        "not_observable": [], "warnings": [], "guessed": list(means.found.guesses),
        "provenance": document_of(provenance_of({table.file.name: table.sha256}, NOT_KNOWN, serial or NOT_KNOWN)),
    }  # fmt: skip
    if latitude_deg is None:
        document["warnings"].append(
            f"no --latitude: gravity is assumed to be {site.gravity:g} +- {site.gravity_std:g} m/s2"
        )
    kept = np.arange(len(means.rows))
    if means.accel is not None:
        per_g = outputs_per_unit(means.found.unit_accel or RAW, ACCEL_UNITS)
        scale, is_stated = per_g or 1.0, means.accel_std is not None
        accel, std = means.accel / scale, _std(means.accel, means.accel_std) / scale
        gravity, gravity_std = site.gravity / STANDARD_GRAVITY, site.gravity_std / STANDARD_GRAVITY
        wrong = find_wrong_poses(accel, std, gravity, is_std_stated=is_stated)
        kept = np.setdiff1d(kept, [one.row for one in wrong if one.probability >= PRESENT])
        poses = PoseTable.of(accel[kept], std[kept], gravity, is_std_stated=is_stated)
        lacking = None if poses is None else diagnose_poses(poses)
        named = lacking if lacking is not None and lacking.findings else None
        fit = calibrate_means(
            named.accel if named else accel[kept], std[kept], gravity, gravity_std, is_std_stated=is_stated,
            effects=None if named is None else named.effects,
        )  # fmt: skip
        if isinstance(fit, Undetermined):
            if means.gyro is None:
                raise NotObservable(f"{table.file.name}: accelerometers by {len(accel)} poses", fit.missing)
            document["not_observable"] += [f"accelerometer: {text}" for text in fit.missing]
        else:
            document["wrong_poses"] = [_wrong_pose(each, means) for each in wrong]
            _add_accelerometer(document, fit, "" if per_g else "output/g", is_stated=is_stated)
            _add_causes(document, lacking)
    if means.gyro is not None:
        _add_gyroscope(document, means, kept)
    return document


def _add_causes(document: dict[str, Any], lacking: PoseDiagnosis | None) -> None:
    """Add the causes found, the errors before and after, and what would separate them."""
    if lacking is not None:
        document["findings"] = [finding_document(each) for each in lacking.findings]
        document["unnamed"] = [unnamed_document(each) for each in lacking.unnamed]
        document["probabilities"] = probabilities_document(lacking.probabilities)
        document["not_separable"] = dict(lacking.not_separable)
        document["error"] = [error_document(each, POSES_LEFT_OUT) for each in lacking.errors]
    measurements = (document["next_measurement"], lacking.next_measurement if lacking else "")
    document["next_measurement"] = "; ".join(filter(None, measurements))
    document["verdict"] = _verdict(document)


def _wrong_pose(wrong: WrongRow, means: MeansTable) -> dict[str, Any]:
    return _pose(wrong.row, wrong.probability, means) | {
        "confidence": word(wrong.probability),
        "off_mg": MG * wrong.off,
        "sigmas": wrong.sigmas,
        "is_held_out": wrong.probability >= PRESENT,
        "alternatives": [_pose(row, share, means) for row, share in wrong.alternatives],
    }


def _pose(row: int, probability: float, means: MeansTable) -> dict[str, Any]:
    at = int(means.rows[row])
    return {"pose": at + 1, "line": means.found.table.line(at), "probability": probability}


def _verdict(document: Mapping[str, Any]) -> Verdict:
    """Return the verdict as of every diagnosis; which of several poses is wrong may be ambiguous."""
    wrong = document["wrong_poses"]
    words = {each["confidence"] for each in (*wrong, *document["findings"])}
    is_left = document.get("log10_p", 0.0) < UNEXPLAINED_LOG_P / np.log(10)
    if is_left and all(each["is_held_out"] for each in wrong):
        return "partly" if words - {"possible"} else "unexplained"
    if "possible" in words:
        return "ambiguous"
    return "likely" if "likely" in words else "established" if words else "consistent"


def _next_measurement(wrong: Sequence[Mapping[str, Any]], fit: MeansCalibration) -> str:
    if wrong:
        each = {one["pose"]: one["line"] for each in wrong for one in (each, *each["alternatives"])}
        lines, poses = (", ".join(map(str, sorted(of))) for of in (each.values(), each))
        return f"check line {lines} of the file, or record pose {poses} again"
    return "record more poses, between the faces" if fit.free < FEW_FREE else ""


def _std(values: FloatArray, stated: FloatArray | None) -> FloatArray:
    """Return the standard uncertainty (n, 3) of means: as stated, and at least what rounding leaves."""
    steps = np.array([_rounding(column) for column in values.T]) / np.sqrt(12)
    found: FloatArray = np.hypot(np.zeros(3) if stated is None else stated, np.broadcast_to(steps, values.shape))
    return found


def _rounding(column: FloatArray) -> float:
    """Return the last digit that a column of decimal numbers was printed with."""
    for digits in range(12):
        if np.all(np.abs(column - np.round(column, digits)) <= 1e-9 * np.maximum(np.abs(column), 1e-3)):
            return 10.0**-digits
    return float(np.spacing(np.max(np.abs(column))))


def _add_accelerometer(document: dict[str, Any], fit: MeansCalibration, unit: str, *, is_stated: bool) -> None:
    off_diagonal = {f"misalignment.{AXES[i]}{AXES[j]}": (i, j) for i in range(3) for j in range(i)}
    E, E_std = fit.E.copy(), fit.E_std.copy()
    for name in fit.not_observable:
        E[off_diagonal[name]] = E_std[off_diagonal[name]] = 0.0
    part: dict[str, Any] = {
        "scale_factor": {"value": fit.k.tolist(), "std": _known(fit.k_std), "unit": unit},
        "bias": {"value": (MG * fit.bias).tolist(), "std": _known(MG * fit.bias_std), "unit": "mg"},
        "residual_rms_mg": MG * float(np.sqrt(np.mean(fit.residual**2))),
        "degrees_of_freedom": round(fit.free, 3),
    }
    if len(fit.not_observable) < len(off_diagonal):
        part["misalignment"] = {"value": E.tolist(), "std": [_known(row) for row in E_std]}
    document["accelerometer"] = part
    document["not_observable"] += [f"accelerometer.{name} (the poses are too close to the faces)" for name in
                                   fit.not_observable]  # fmt: skip
    document["not_observable"].append("accelerometer: its axes relative to the housing (poses are not known)")
    if is_stated:
        part |= {"noise_rms_mg": MG * float(np.sqrt(np.mean(fit.noise**2))), "chi2": fit.chi2}
        if fit.free >= LEAST_FREE:
            document["log10_p"] = log_chi2_sf(fit.chi2, fit.free) / np.log(10)
    document["next_measurement"] = _next_measurement(document["wrong_poses"], fit)
    held = fit.held_out[np.isfinite(fit.held_out)]
    warnings = document["warnings"]
    if len(held):
        part["held_out_rms_mg"] = MG * float(np.sqrt(np.mean(held**2)))
        part["held_out_poses"] = len(held)
    if len(held) < len(fit.held_out):
        needed = len(fit.held_out) - len(held)
        warnings.append(
            f"{needed} of {len(fit.held_out)} poses cannot be predicted from the others: all are needed"
        )
    if fit.free < 1 and not is_stated:
        warnings.append("as many parameters as poses and no standard deviations: uncertainties are not known")
    elif fit.free < FEW_FREE:
        warnings.append(f"only {fit.free:.2g} degrees of freedom to check the fit")


def _add_gyroscope(document: dict[str, Any], means: MeansTable, kept: IntArray) -> None:
    assert means.gyro is not None
    value, std = gyro_bias(means.gyro[kept], _std(means.gyro, means.gyro_std)[kept])
    unit = means.found.unit_gyro or "output"
    document["gyroscope"] = {"bias": {"value": value.tolist(), "std": _known(std), "unit": unit}}
    per_deg_s = outputs_per_unit(means.found.unit_gyro or RAW, GYRO_UNITS)
    if per_deg_s is not None:
        document["gyroscope"]["earth_rate_in_bias"] = ANY_EARTH_RATE_DEG_H / 3600 * per_deg_s
    document["not_observable"] += ["gyroscope.scale_factor", "gyroscope.misalignment (no rotation)"]


def _known(std: FloatArray) -> list[float | None]:
    return [float(each) if np.isfinite(each) else None for each in std]
