"""A solution as `solution/1` (docs/reference/file-formats.md): what was not estimated is absent."""

import hashlib
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, FitQuality, Solution, TriadCalibration
from procedures.calibration.undetectable_tilt import ANY_TILT_RAD, UndetectableTilt
from procedures.units import RAD_PER_ARCSEC
from station.files.campaign_folder.loaded_campaign import LoadedCampaign

FORMAT = "solution/1"


@dataclass(frozen=True, slots=True, eq=False)
class JointEstimate(Estimate):
    """The bias of the joint fit."""

    estimator: str = "joint"


@dataclass(frozen=True, slots=True)
class SolvedTriad:
    """What was estimated of a triad: values (3,) and (3, 3) with standard uncertainties."""

    scale_factor: Estimate | None = None
    misalignment: Estimate | None = None
    bias_12_position: Estimate | None = None
    bias_two_direction: Estimate | None = None
    bias: Estimate | None = None


@dataclass(frozen=True, slots=True)
class Residual:
    """The global test of the fit."""

    accelerometer_rms_g: float | None
    gyroscope_rms_deg_h: float | None
    chi2: float | None
    dof: int
    p_value: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Covariance:
    """Of all parameters by name, (n, n) in products of their units."""

    names: tuple[str, ...]
    matrix: FloatArray


@dataclass(frozen=True, slots=True)
class DetectableTilt:
    """The smallest tilt of a dwell that would be detected every second time, and what it moves by how much."""

    campaign: int
    step: str
    position: int
    lean_arcsec: float
    value: str
    sigmas: float


@dataclass(frozen=True, slots=True)
class Provenance:
    """The hashes of all files used, the unit, the software, where it is kept, and the time."""

    files: Mapping[str, str]
    model: str
    serial: str
    software: str | None
    created_utc: str


@dataclass(frozen=True, slots=True)
class SolutionDocument:
    """A solution and where it comes from; the fields of this and of what it holds are the keys of `solution/1`.

    ``effects`` are the entries of the error terms that it holds.
    """

    format: str
    accelerometer: SolvedTriad | None
    gyroscope: SolvedTriad | None
    slab: Mapping[str, Estimate] | None
    fixture: Mapping[str, Estimate] | None
    residual: Residual
    covariance: Covariance | None
    reference_temperature_c: float | None
    effects: Sequence[Mapping[str, Any]] | None
    unnoticed_leans: Sequence[DetectableTilt] | None
    not_observable: Sequence[str]
    warnings: Sequence[str]
    unused_steps: Sequence[str]
    provenance: Provenance

    @property
    def triads(self) -> Mapping[str, SolvedTriad | None]:
        """Both triads by name."""
        return {"accelerometer": self.accelerometer, "gyroscope": self.gyroscope}


def solution_document(
    solution: Solution,
    campaigns: Sequence[LoadedCampaign],
    effects: Sequence[Mapping[str, Any]] = (),
    *,
    to_keep: bool = True,
) -> SolutionDocument:
    """Return a solution and where it comes from; ``effects`` are those that it holds.

    Not ``to_keep`` it lacks the software, which git is asked for: a summary does not say it.

    Warnings and unused steps of the folders stand before those of the solve. What is not finite is not
    estimated: it is left out and a warning says so.
    """
    dropped = list[str]()
    parts: dict[str, Any] = {
        "accelerometer": _triad("accelerometer", solution.accelerometer, dropped),
        "gyroscope": _triad("gyroscope", solution.gyroscope, dropped),
        "slab": _part("slab", "tilt_rad", solution.slab_tilt, dropped),
        "fixture": _part("fixture", "parallelism_rad", solution.parallelism, dropped),
        "covariance": _covariance(solution, dropped),
    }
    warnings = [w for loaded in campaigns for w in loaded.warnings] + list(solution.warnings)
    warnings += [f"{name} is not finite and was omitted" for name in dropped]
    unused = [s for loaded in campaigns for s in loaded.unused_steps] + list(solution.unused_steps)
    return SolutionDocument(
        format=FORMAT,
        **parts,
        residual=_residual(solution.quality),
        reference_temperature_c=_finite(solution.reference_temperature),
        effects=effects or None,
        unnoticed_leans=[_tilt(each) for each in solution.undetectable_tilts] or None,
        not_observable=solution.not_observable,
        warnings=_once(warnings),
        unused_steps=_once(unused),
        provenance=provenance(campaigns, to_keep=to_keep),
    )


def provenance(campaigns: Sequence[LoadedCampaign], *, to_keep: bool = True) -> Provenance:
    """Return where a result comes from, with the software where it is ``to_keep``."""
    imu = campaigns[0].tables.imu
    return provenance_of(input_hashes(campaigns), imu.model, imu.serial, to_keep=to_keep)


def provenance_of(files: Mapping[str, str], model: str, serial: str, *, to_keep: bool = True) -> Provenance:
    """Return the same of files, by name with their sha256, that are no campaign."""
    now = datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
    return Provenance(files, model, serial, software_version() if to_keep else None, now)


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


def _triad(name: str, triad: TriadCalibration | None, dropped: list[str]) -> SolvedTriad | None:
    if triad is None:
        return None
    names = [one.name for one in fields(SolvedTriad)]
    found = SolvedTriad(**{one: _known(f"{name}.{one}", getattr(triad, one), dropped) for one in names})
    if found.bias is not None:
        found = replace(found, bias=JointEstimate(found.bias.value, found.bias.std, found.bias.unit))
    return None if found == SolvedTriad() else found


def _part(name: str, field: str, one: Estimate | None, dropped: list[str]) -> dict[str, Estimate] | None:
    found = _known(f"{name}.{field}", one, dropped)
    return None if found is None else {field: found}


def _known(name: str, one: Estimate | None, dropped: list[str]) -> Estimate | None:
    if one is None or (np.isfinite(one.value).all() and np.isfinite(one.std).all()):
        return one
    dropped.append(name)
    return None


def _covariance(solution: Solution, dropped: list[str]) -> Covariance | None:
    if not len(solution.names):
        return None
    if not np.isfinite(solution.covariance).all():
        dropped.append("covariance")
        return None
    return Covariance(solution.names, solution.covariance)


def _residual(quality: FitQuality) -> Residual:
    return Residual(
        _finite(quality.accelerometer_rms_g), _finite(quality.gyroscope_rms_dph), _finite(quality.chi2),
        quality.dof, _finite(quality.p_value),
    )  # fmt: skip


def _tilt(one: UndetectableTilt) -> DetectableTilt:
    tilt = min(one.tilt, ANY_TILT_RAD) / RAD_PER_ARCSEC
    return DetectableTilt(one.campaign + 1, Path(one.step).stem, one.position, tilt, one.value, one.sigmas)


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and np.isfinite(value) else None


def _once(texts: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(texts))
