"""A `solution/1` document as text to read: every value with its standard uncertainty and unit."""

from collections.abc import Mapping, Sequence
from math import floor, log10
from typing import Any

import numpy as np

from procedures.frames import AXES
from procedures.units import RAD_PER_ARCSEC
from station.text import plural, unit_in_words

TOO_LONG = 1e12  # to be read digit by digit
PLAIN, PLAIN_DECIMALS = 0.1, 12  # from which size on, and up to how many decimals, a value stands without a power
EXACT = 2e-3  # of a millionth: 0 by the choice of axes, held there to 1e-9 rad
NOT_SOLVED = "not solved"
USED_HOW = "(u is of the fit alone; when you use a value, use the expanded uncertainty U of `station report`)"


def solution_text(document: Mapping[str, Any]) -> str:
    """Return the summary that ``station solve`` prints; +- is the standard uncertainty u."""
    origin = document["provenance"]
    who, files = unit_in_words(origin["model"], origin["serial"]), plural(len(origin["files"]), "file")
    lines = [f"{who}: {files}, +- is the standard uncertainty u"]
    lines += [USED_HOW] if "accelerometer" in document or "gyroscope" in document else []
    lines += triad_lines(document)
    lines += [line for effect in document.get("effects", ()) for line in effect_lines(effect)]
    lines += _tilt(document) + _parallelism(document) + _residual(document.get("residual", {}))
    for key, title in (
        ("not_observable", "not observable"),
        ("warnings", "warning"),
        ("unused_steps", "checked but not used"),
    ):
        lines += [f"{title}: {text}" for text in document[key]]
    return "\n".join(lines)


def triad_lines(document: Mapping[str, Any]) -> list[str]:
    """Return the calibration of both triads, +- u; what is not solved is listed as such."""
    unseen = document.get("not_observable", ())
    return [line for name in ("accelerometer", "gyroscope") for line in _triad(name, document.get(name), unseen)]


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


def _triad(name: str, part: Mapping[str, Any] | None, unseen: Sequence[str]) -> list[str]:
    if part is None:
        return [f"{name}: {NOT_SOLVED}"]
    lines = [name]
    for key, title in (
        ("scale_factor", "scale factor"),
        ("bias", "bias"),
        ("bias_12_position", "bias, 12 positions"),
        ("bias_two_direction", "bias, two directions"),
    ):
        lines += _vector(title, part.get(key))
    if misalignment := part.get("misalignment"):
        lines.append("  misalignment minus identity, row = sensor [1e-6]")
        excess = np.array(misalignment["value"]) - np.eye(3)
        for axis, values, stds in zip(AXES, excess * 1e6, np.array(misalignment["std"]) * 1e6, strict=True):
            row = [
                measured(v, s) if s > EXACT else measured(round(v, 2), 0.0)
                for v, s in zip(values, stds, strict=True)
            ]
            for i, other in enumerate(AXES):
                if any(each.startswith(f"{name}.misalignment.{axis}{other} ") for each in unseen):
                    row[i] = "not observable"
            lines.append(f"    {axis}  {'   '.join(row)}")
    return lines


def _vector(title: str, estimate: Mapping[str, Any] | None) -> list[str]:
    if estimate is None:
        return []
    rows = zip(AXES, estimate["value"], estimate["std"], strict=True)
    return [f"  {title:<21} {axis}  {measured(value, std, estimate['unit'])}" for axis, value, std in rows]


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


def _tilt(document: Mapping[str, Any]) -> list[str]:
    if "slab" not in document:
        return []
    tilt = document["slab"]["tilt_rad"]
    east, north = _in_arcsec(tilt["value"], tilt["std"])
    return [f"surface plate tilt      east {east} arcsec, north {north} arcsec"]


def _parallelism(document: Mapping[str, Any]) -> list[str]:
    if "fixture" not in document:
        return []
    both = document["fixture"]["parallelism_rad"]
    lines = ["parallelism of the cube's faces, sum of a pair [arcsec]"]
    for pair, values, stds in zip(AXES, both["value"], both["std"], strict=True):
        others = [axis for axis in AXES if axis != pair]
        row = [f"{axis} {text}" for axis, text in zip(others, _in_arcsec(values, stds), strict=True)]
        lines.append(f"    {pair} faces: along {', along '.join(row)}")
    return lines


def _in_arcsec(values: Sequence[float], stds: Sequence[float]) -> list[str]:
    return [measured(v / RAD_PER_ARCSEC, s / RAD_PER_ARCSEC) for v, s in zip(values, stds, strict=True)]


def _residual(residual: Mapping[str, Any]) -> list[str]:
    text = []
    if (rms := residual.get("accelerometer_rms_g")) is not None:
        text.append(f"accelerometer {rms:.3g} g rms")
    if (rms := residual.get("gyroscope_rms_deg_h")) is not None:
        text.append(f"gyroscope {rms:.3g} deg/h rms")
    if "chi2" in residual:
        text.append(f"chi2 {residual['chi2']:.1f} of {residual['dof']} degrees of freedom")
    if "p_value" in residual:
        text.append(f"p {residual['p_value']:.3g}")
    return [f"residual: {', '.join(text)}"] if text else []
