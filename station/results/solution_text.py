"""A `solution/1` as text to read: every value with its standard uncertainty and unit."""

from collections.abc import Mapping, Sequence
from math import floor, log10
from typing import Any

import numpy as np

from procedures.calibration.solution_values import Estimate
from procedures.frames import AXES
from procedures.units import ARCSEC_PER_RAD
from station.results.parameters_by_name import KINDS
from station.results.solution_json import Residual, SolutionDocument, SolvedTriad
from station.text import plural, unit_in_words

TOO_LONG = 1e12  # to be read digit by digit
PLAIN, PLAIN_DECIMALS = 0.1, 12  # from which size on, and up to how many decimals, a value stands without a power
EXACT = 2e-3  # of a millionth: 0 by the choice of axes, held there to 1e-9 rad
NOT_SOLVED = "not solved"
USED_HOW = "(u is of the fit alone; when you use a value, use the expanded uncertainty U of `station report`)"


def solution_text(document: SolutionDocument) -> str:
    """Return the summary that ``station solve`` prints; +- is the standard uncertainty u."""
    origin, triads = document.provenance, document.triads
    who, files = unit_in_words(origin.model, origin.serial), plural(len(origin.files), "file")
    lines = [f"{who}: {files}, +- is the standard uncertainty u", *([USED_HOW] if any(triads.values()) else [])]
    lines += triad_lines(triads, document.not_observable)
    lines += [line for effect in document.effects or () for line in effect_lines(effect)]
    lines += [*_bench(document), *_residual(document.residual)]
    lines += [f"not observable: {text}" for text in document.not_observable]
    lines += [f"warning: {text}" for text in document.warnings]
    return "\n".join([*lines, *(f"checked but not used: {text}" for text in document.unused_steps)])


def triad_lines(triads: Mapping[str, SolvedTriad | None], not_observable: Sequence[str]) -> list[str]:
    """Return the calibration of both triads, +- u; what is not solved is listed as such."""
    return [line for name, triad in triads.items() for line in _triad(name, triad, not_observable)]


def measured(value: float, std: float, unit: str = "") -> str:
    """Return ``value +- std unit`` with two digits of the uncertainty."""
    if not std > 0:
        return f"{value:z.9g} {unit}".rstrip()
    if abs(value) >= TOO_LONG:
        return f"{value:.4g} +- {std:.2g} {unit}".rstrip()
    decimals = 1 - floor(log10(std))
    if decimals > (PLAIN_DECIMALS if abs(value) >= PLAIN else 7):
        return f"{value:z.{max(0, decimals + floor(log10(abs(value) or std)))}e} +- {std:.1e} {unit}".rstrip()
    digits = max(0, decimals)
    return f"{value:z.{digits}f} +- {std:.{digits}f} {unit}".rstrip()


def _triad(name: str, triad: SolvedTriad | None, unseen: Sequence[str]) -> list[str]:
    if triad is None:
        return [f"{name}: {NOT_SOLVED}"]
    lines = [name]
    for kind in KINDS:
        if (one := getattr(triad, kind.field)) is not None and one is not triad.misalignment:
            title = f"  {kind.name + kind.method:<21}"
            lines += [f"{title} {axis}  {text}" for axis, text in zip(AXES, _all_measured(one), strict=True)]
    if triad.misalignment is None:
        return lines
    lines.append("  misalignment minus identity, row = sensor [1e-6]")
    excess = (triad.misalignment.value - np.eye(3)) * 1e6
    for axis, values, stds in zip(AXES, excess.tolist(), (triad.misalignment.std * 1e6).tolist(), strict=True):
        row = [
            measured(v, s) if s > EXACT else measured(round(v, 2), 0.0) for v, s in zip(values, stds, strict=True)
        ]
        for i, other in enumerate(AXES):
            if any(each.startswith(f"{name}.misalignment.{axis}{other} ") for each in unseen):
                row[i] = "not observable"
        lines.append(f"    {axis}  {'   '.join(row)}")
    return lines


def _all_measured(one: Estimate, scale: float = 1.0, unit: str | None = None) -> list[str]:
    """Return every value of an estimate (n,), row by row, in its own unit or times ``scale`` in another."""
    pairs = zip((one.value.ravel() * scale).tolist(), (one.std.ravel() * scale).tolist(), strict=True)
    return [measured(value, std, one.unit if unit is None else unit) for value, std in pairs]


def effect_rows(effect: Mapping[str, Any]) -> tuple[str, list[tuple[str, str]]]:
    """Return an effect that the solution holds, its hash where it is of a file, and its coefficients with u."""
    short = f" (effect/1, sha256 {effect['sha256'][:12]})" if "sha256" in effect else ""
    units = effect.get("units", {})
    return f"{effect['name']}{short}", [
        (name, measured(one["value"], one["std"], units.get(name, effect["unit"])))
        for name, one in effect["coefficients"].items()
    ]


def effect_lines(effect: Mapping[str, Any]) -> list[str]:
    """Return the same as lines of text."""
    title, rows = effect_rows(effect)
    return [title, *(f"  {name:<23} {value}" for name, value in rows)]


def _bench(document: SolutionDocument) -> list[str]:
    """Return the tilt of the surface plate and the parallelism of the cube's faces, in arcsec."""
    lines = list[str]()
    if document.slab is not None:
        east, north = _all_measured(document.slab["tilt_rad"], ARCSEC_PER_RAD, "arcsec")
        lines.append(f"surface plate tilt      east {east}, north {north}")
    if document.fixture is not None:
        lines.append("parallelism of the cube's faces, sum of a pair [arcsec]")
        texts = iter(_all_measured(document.fixture["parallelism_rad"], ARCSEC_PER_RAD, ""))
        for pair in AXES:
            along = [f"along {axis} {next(texts)}" for axis in AXES if axis != pair]
            lines.append(f"    {pair} faces: {', '.join(along)}")
    return lines


def _residual(residual: Residual) -> list[str]:
    text = []
    if (rms := residual.accelerometer_rms_g) is not None:
        text.append(f"accelerometer {rms:.3g} g rms")
    if (rms := residual.gyroscope_rms_deg_h) is not None:
        text.append(f"gyroscope {rms:.3g} deg/h rms")
    if residual.chi2 is not None:
        text.append(f"chi2 {residual.chi2:.1f} of {residual.dof} degrees of freedom")
    if residual.p_value is not None:
        text.append(f"p {residual.p_value:.3g}")
    return [f"residual: {', '.join(text)}"] if text else []
