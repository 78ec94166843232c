"""A `solution/1` document as text to read: every value with its standard uncertainty and unit."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from math import floor, log10
from operator import itemgetter
from typing import Any

import numpy as np

from procedures.frames import AXES
from procedures.units import ARCSEC_PER_RAD
from station.results.parameters_by_name import KINDS, Parameter, parameters
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
    lines += _bench(document) + _residual(document.get("residual", {}))
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
    vectors = {field: one for field, one in part.items() if field != "misalignment"}
    titles = {kind.field: kind.name + kind.method for kind in KINDS}
    rows = [
        (titles[one.name.split(".")[1]], one.name[-1], _measured(one))
        for one in parameters({name: vectors}).values()
    ]
    lines = [name, *(f"  {title:<21} {axis}  {text}" for title, axis, text in rows)]
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


def _measured(one: Parameter, scale: float = 1.0, unit: str | None = None) -> str:
    return measured(scale * one.value, scale * (one.std or 0.0), one.unit if unit is None else unit)


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


def _bench(document: Mapping[str, Any]) -> list[str]:
    """Return the tilt of the surface plate and the parallelism of the cube's faces, in arcsec."""
    found = parameters(document)
    in_arcsec = {name: _measured(one, ARCSEC_PER_RAD, "") for name, one in found.items() if one.unit == "rad"}
    tilt = [
        f"{name.removeprefix('slab.tilt.')} {text} arcsec"
        for name, text in in_arcsec.items()
        if name.startswith("slab.tilt.")
    ]
    lines = [f"surface plate tilt      {', '.join(tilt)}"] if tilt else []
    faces = [(*name.split(".")[2:], text) for name, text in in_arcsec.items() if name.startswith("fixture.")]
    lines += ["parallelism of the cube's faces, sum of a pair [arcsec]"] if faces else []
    for pair, group in groupby(faces, itemgetter(0)):
        lines.append(f"    {pair} faces: {', '.join(f'along {axis} {text}' for _, axis, text in group)}")
    return lines


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
