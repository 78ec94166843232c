"""A solution as `solution/1` (docs/reference/file-formats.md): JSON-ready; what was not estimated is absent."""

import hashlib
import subprocess
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path
from typing import Any

import numpy as np

from procedures.calibration.solution_values import Estimate, FitQuality, Solution, TriadCalibration
from procedures.calibration.undetectable_tilt import ANY_TILT_RAD, UndetectableTilt
from procedures.units import RAD_PER_ARCSEC
from station.files.campaign_folder.loaded_campaign import LoadedCampaign

FORMAT = "solution/1"


def solution_document(
    solution: Solution,
    campaigns: Sequence[LoadedCampaign],
    effects: Sequence[Mapping[str, Any]] = (),
    *,
    to_keep: bool = True,
) -> dict[str, Any]:
    """Return a solution and where it comes from as `solution/1`; ``effects`` are those that it holds.

    Not ``to_keep`` it lacks the software, which git is asked for: a summary does not say it.

    Warnings and unused steps of the folders stand before those of the solve. What is not finite is not
    estimated: it is left out and a warning says so.
    """
    dropped = list[str]()
    parts = {
        "accelerometer": _triad("accelerometer", solution.accelerometer, dropped),
        "gyroscope": _triad("gyroscope", solution.gyroscope, dropped),
        "slab": _part("slab", {"tilt_rad": solution.slab_tilt}, dropped),
        "fixture": _part("fixture", {"parallelism_rad": solution.parallelism}, dropped),
        "residual": _quality(solution.quality),
        "covariance": _covariance(solution, dropped),
        "reference_temperature_c": _finite(solution.reference_temperature),
    }
    warnings = [w for loaded in campaigns for w in loaded.warnings] + list(solution.warnings)
    warnings += [f"{name} is not finite and was omitted" for name in dropped]
    unused = [s for loaded in campaigns for s in loaded.unused_steps] + list(solution.unused_steps)
    return {
        "format": FORMAT,
        **{name: part for name, part in parts.items() if part is not None and part != {}},
        **({"effects": [dict(effect) for effect in effects]} if effects else {}),
        **({"unnoticed_leans": tilts} if (tilts := [_tilt(each) for each in solution.undetectable_tilts]) else {}),
        "not_observable": list(solution.not_observable),
        "warnings": _once(warnings),
        "unused_steps": _once(unused),
        "provenance": provenance(campaigns, to_keep=to_keep),
    }


def provenance(campaigns: Sequence[LoadedCampaign], *, to_keep: bool = True) -> dict[str, Any]:
    """Return the hashes of all files used, the unit, the software, where it is ``to_keep``, and the time."""
    imu = campaigns[0].tables.imu
    return {
        "files": input_hashes(campaigns),
        "model": imu.model,
        "serial": imu.serial,
        **({"software": software_version()} if to_keep else {}),
        "created_utc": datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z"),
    }


def input_hashes(campaigns: Sequence[LoadedCampaign]) -> dict[str, str]:
    """Return the sha256 of each file; its name is preceded by its folder's where several campaigns are used."""
    if len(campaigns) == 1:
        return dict(campaigns[0].files)
    labels = [loaded.folder.resolve().name for loaded in campaigns]
    if len(set(labels)) < len(labels):
        labels = [str(loaded.folder.resolve()) for loaded in campaigns]
    return {f"{x}/{n}": h for x, loaded in zip(labels, campaigns, strict=True) for n, h in loaded.files.items()}


@cache
def software_version() -> str:
    """Return name, version and the commit of a checkout (``-dirty`` where files differ from it).

    Of an installed wheel a hash of its sources stands in place of the commit. Asked once: what runs is what was
    there when the process began.
    """
    try:
        name = f"fog-station {version('fog-station')}"
    except PackageNotFoundError:
        name = "fog-station (not installed)"
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return f"{name} (sources {sources})" if (sources := installed_sources()) else name
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        commit = subprocess.run(command, capture_output=True, text=True, timeout=5, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return name
    return f"{name} ({commit})"


def installed_sources() -> str:
    """Return the first digits of a SHA-256 over the hashes of all sources in a wheel; nothing where none is."""
    try:
        files = distribution("fog-station").files or ()
    except PackageNotFoundError:
        return ""
    hashes = sorted(f"{file} {file.hash.value}" for file in files if file.suffix == ".py" and file.hash)
    return hashlib.sha256("\n".join(hashes).encode()).hexdigest()[:12] if hashes else ""


def _triad(name: str, triad: TriadCalibration | None, dropped: list[str]) -> dict[str, Any]:
    fields = ("scale_factor", "misalignment", "bias_12_position", "bias_two_direction", "bias")
    part = _part(name, {field: getattr(triad, field) for field in fields} if triad else {}, dropped)
    if "bias" in part:
        part["bias"]["estimator"] = "joint"
    return part


def _part(name: str, estimates: Mapping[str, Estimate | None], dropped: list[str]) -> dict[str, Any]:
    part = dict[str, Any]()
    for field, one in estimates.items():
        if one is not None and np.isfinite(one.value).all() and np.isfinite(one.std).all():
            part[field] = estimate_document(one)
        elif one is not None:
            dropped.append(f"{name}.{field}")
    return part


def estimate_document(estimate: Estimate) -> dict[str, Any]:
    """Return a value with its sigma and unit as files have it."""
    return {"value": estimate.value.tolist(), "std": estimate.std.tolist(), "unit": estimate.unit}


def _quality(quality: FitQuality) -> dict[str, Any]:
    values = {
        "accelerometer_rms_g": _finite(quality.accelerometer_rms_g),
        "gyroscope_rms_deg_h": _finite(quality.gyroscope_rms_dph),
        "chi2": _finite(quality.chi2),
        "dof": quality.dof,
        "p_value": _finite(quality.p_value),
    }
    return {name: value for name, value in values.items() if value is not None}


def _tilt(one: UndetectableTilt) -> dict[str, Any]:
    return {
        "campaign": one.campaign + 1,
        "step": Path(one.step).stem,
        "position": one.position,
        "lean_arcsec": min(one.tilt, ANY_TILT_RAD) / RAD_PER_ARCSEC,
        "value": one.value,
        "sigmas": one.sigmas,
    }


def _covariance(solution: Solution, dropped: list[str]) -> dict[str, Any] | None:
    if not len(solution.names):
        return None
    if not np.isfinite(solution.covariance).all():
        dropped.append("covariance")
        return None
    return {"names": list(solution.names), "matrix": solution.covariance.tolist()}


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and np.isfinite(value) else None


def _once(texts: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(texts))
