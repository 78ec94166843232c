"""The calibration by a table of means as a `means/1` document, and as text."""

from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate
from procedures.errors import ErrorCode
from procedures.frames import AXES, TRIADS
from procedures.free_positions.norm_fit import Undetermined
from procedures.free_positions.pose_means import MeansCalibration, calibrate_means, gyro_bias
from procedures.units import STANDARD_GRAVITY
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import ANY_EARTH_RATE_DEG_H, site_of
from station.files.campaign_folder.campaign_schema import SiteTable
from station.files.logs.means_table import MeansTable
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, RAW, outputs_per_unit
from station.results.solution_json import SolvedTriad
from station.results.solution_text import triad_lines

FEW_FREE = 4.0  # degrees of freedom, below which a sigma from the scatter is itself known to no better than 35 %
HELD_OUT_FACTOR = 2.0  # held-out error over in-sample error, from which on the poses are too few
MG = 1e3


def means_document(means: MeansTable, latitude_deg: float | None, serial: str | None) -> dict[str, Any]:
    """Return what a table of means says.

    Raises
    ------
    DataRefused
        If its poses determine no accelerometer, and there is no gyroscope either.
    """
    file = means.found.table.file
    site = site_of(None if latitude_deg is None else SiteTable(latitude_deg=latitude_deg))
    document: dict[str, Any] = {
        "format": "means/1", "file": file.name, "sha256": means.found.table.sha256, "serial": serial,
        "poses": len(means.accel if means.accel is not None else means.gyro),  # type: ignore[arg-type]
        "not_observable": [], "warnings": [],
    }  # fmt: skip
    if latitude_deg is None:
        document["warnings"].append(
            f"no --latitude: gravity is assumed to be {site.gravity:g} +- {site.gravity_std:g} m/s2"
        )
    if means.accel is not None:
        per_g = outputs_per_unit(means.found.unit_accel or RAW, ACCEL_UNITS)
        scale = per_g or 1.0
        std = _std(means.accel, means.accel_std)
        fit = calibrate_means(
            means.accel / scale, std / scale, site.gravity / STANDARD_GRAVITY, site.gravity_std / STANDARD_GRAVITY,
            is_std_stated=means.accel_std is not None,
        )  # fmt: skip
        if isinstance(fit, Undetermined):
            if means.gyro is None:
                found = f"{len(means.accel)} poses that determine no calibration"
                raise DataRefused(file, None, found, "; ".join(fit.missing), "add poses", ErrorCode.NOT_OBSERVABLE)
            document["not_observable"] += [f"accelerometer: {text}" for text in fit.missing]
        else:
            _add_accelerometer(document, fit, "" if per_g else "output/g", is_stated=means.accel_std is not None)
    if means.gyro is not None:
        _add_gyroscope(document, means)
    return document


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
        warnings.append(f"only {fit.free:.1f} degrees of freedom to check the fit: add poses between the faces")
    fitted, predicted = part["residual_rms_mg"], part.get("held_out_rms_mg", 0.0)
    if predicted > HELD_OUT_FACTOR * fitted:
        warnings.append(
            f"poses are fitted to {fitted:.3g} mg and predicted to {predicted:.3g} mg: too few poses for so many "
            "parameters, so the fit looks better than it is"
        )


def _add_gyroscope(document: dict[str, Any], means: MeansTable) -> None:
    assert means.gyro is not None
    value, std = gyro_bias(means.gyro, _std(means.gyro, means.gyro_std))
    unit = means.found.unit_gyro or "output"
    document["gyroscope"] = {"bias": {"value": value.tolist(), "std": _known(std), "unit": unit}}
    per_deg_s = outputs_per_unit(means.found.unit_gyro or RAW, GYRO_UNITS)
    if per_deg_s is not None:
        document["gyroscope"]["earth_rate_in_bias"] = ANY_EARTH_RATE_DEG_H / 3600 * per_deg_s
    document["not_observable"] += ["gyroscope.scale_factor", "gyroscope.misalignment (no rotation)"]


def _known(std: FloatArray) -> list[float | None]:
    return [float(each) if np.isfinite(each) else None for each in std]


def means_text(document: dict[str, Any]) -> str:
    """Return the document as text; +- is the standard uncertainty."""
    lines = [
        f"{document['file']}: a table of means of {document['poses']} poses, +- is the standard uncertainty u"
    ]
    lines += triad_lines({name: _estimates(document[name]) for name in TRIADS if name in document}, ())
    if part := document.get("accelerometer"):
        lines.append(
            f"residual: {part['residual_rms_mg']:.3g} mg rms, {part['degrees_of_freedom']:g} degrees of freedom"
        )
        if "held_out_rms_mg" in part:
            lines.append(f"held out: {part['held_out_rms_mg']:.3g} mg rms, each pose predicted from the others")
    if earth := document.get("gyroscope", {}).get("earth_rate_in_bias"):
        unit = document["gyroscope"]["bias"]["unit"]
        lines.append(f"the gyroscopes' bias includes the Earth's rate: up to {earth:.2g} {unit}")
    lines += [f"not observable: {text}" for text in document["not_observable"]]
    lines += [f"warning: {text}" for text in document["warnings"]]
    return "\n".join(lines)


def _estimates(part: dict[str, Any]) -> SolvedTriad:
    """Return a triad's estimates with 0 for a sigma that is not known, which is then not shown."""
    stated = {key: one for key, one in part.items() if isinstance(one, dict)}
    return SolvedTriad(**{
        key: Estimate(np.array(one["value"]), np.nan_to_num(np.array(one["std"], float)), one.get("unit", ""))
        for key, one in stated.items()
    })  # fmt: skip
