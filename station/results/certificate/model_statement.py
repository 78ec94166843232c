"""What a certificate says of the model: what the diagnosis found, what is taken as zero, what is only stated."""

from collections.abc import Mapping
from math import floor, log10
from typing import Any

NEVER_SOLVED = {
    "accelerometer": ("accelerometer.quadratic", "accelerometer.scale_asymmetry"),
    "gyroscope": ("gyroscope.scale_asymmetry",),
}
NAMES = {
    "accelerometer.quadratic": "quadratic term of the accelerometers (K2)",
    "fixture.parallelism": "cube parallelism",
}
SLAB_RANGE_DEG = 0.29  # procedures.twelve_positions.bench_parameters.SLAB_TILT_RANGE_RAD, 5e-3 rad
SIMULATED = "SIM-"  # how every model of drivers.simulated begins
PROGRAM = "run `station"  # in a warning that speaks to the operator


def is_simulated(document: Mapping[str, Any]) -> bool:
    """Say whether a calibration/1 is one of a simulated device, as far as its model says."""
    return str(document["model"]).upper().startswith(SIMULATED)


def diagnosis_in_words(document: Mapping[str, Any]) -> list[str]:
    """Return sentences of what the diagnosis stored with a calibration/1 found in the residual."""
    own = declared_in_words(document)
    diagnosis = document.get("diagnosis")
    if diagnosis is None:
        return [*own, "No diagnosis of the residual is stored with this calibration."]
    findings, reported = diagnosis["findings"], list[str]()
    sure = [f"{_name(f['effect'])} ({f['confidence']})" for f in findings if f["confidence"] != "possible"]
    if sure:
        reported.append(f"Found in the residual: {'; '.join(sure)}.")
    doubtful = [(f["effect"], *f["aliases"]) for f in findings if f["confidence"] == "possible"]
    parts = [names[0] for names in doubtful if len(names) == 1]
    if parts:
        reported.append(f"Explains the residual only in part: {'; '.join(map(_name, parts))}.")
    several = [names for names in doubtful if len(names) > 1]
    for group in dict.fromkeys(" or ".join(dict.fromkeys(map(_name, names))) for names in several):
        reported.append(f"Not separated by this campaign: {group}.")
    if diagnosis["verdict"] == "consistent":
        reported.append("The residuals are consistent with noise: no further error term was detected.")
    elif diagnosis["verdict"] not in {"established", "likely", "ambiguous"}:
        left = " The unexplained part is included in U." if _shares(document, "unexplained") else ""
        whole = "all of it" if diagnosis["verdict"] == "partly" else "it"
        reported.append(f"The residuals exceed noise, and no known error term explains {whole}.{left}")
    return [*own, f"Diagnosis of the residual: {diagnosis['verdict']}.", *reported]


def declared_in_words(document: Mapping[str, Any]) -> list[str]:
    """Return sentences of the effects that files of effect/1 put into the model of a calibration/1."""
    return [
        f"Also in the model: {each['name']}, c ({'; '.join(each['term'])}), c in {each['unit']}, as defined by "
        f"the file of SHA-256 {each['sha256']}."
        for each in document.get("effects", ())
        if "definition" in each
    ]


def effect_rows(document: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Return a line for each coefficient of the effects of a calibration/1: name, value, u, unit."""
    rows = list[tuple[str, str, str, str]]()
    for one in document.get("effects", ()):
        for name, reported in one["coefficients"].items():
            unit, std = str(one.get("units", {}).get(name, one["unit"])), reported.get("std")
            value = (
                f"{reported['value']:.6g}"
                if not std
                else f"{reported['value']:.{max(_digits(reported['value'], std), 1)}g}"
            )
            rows.append((f"{_name(one['name'])}, {name}", value, "" if std is None else f"{std:.2g}", unit))
    return rows


def taken_as_zero(document: Mapping[str, Any]) -> list[str]:
    """Return what the model takes as zero: what the steps did not show, and what no solve of it holds."""
    steps = list(document["procedure"].get("not_observable", ()))
    carried = {effect["name"] for effect in document.get("effects", ())}
    never = [name for triad, names in NEVER_SOLVED.items() if triad in document for name in names]
    return steps + [
        name for name in never if name not in carried and not any(text.startswith(name) for text in steps)
    ]


def residual_in_words(document: Mapping[str, Any], warning: str) -> str:
    """Return a warning of the program as the customer may read it."""
    if PROGRAM not in warning:
        return warning
    what = warning.partition(": the uncertainties")[0]
    return f"{what}; the unexplained part is included in U" if _shares(document, "unexplained") else what


def stated(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return label and text of what was taken as stated and not measured."""
    procedure, lines = document["procedure"], list[tuple[str, str]]()
    for label, key in (
        ("Heading of a position", "heading_std_deg"),
        ("Closure error of a rotation", "closure_std_deg"),
    ):
        if key in procedure:
            lines.append((label, f"u = {procedure[key]:g}\u00b0"))
    lines.append(("Tilt of the surface plate", f"estimated, prior standard uncertainty {SLAB_RANGE_DEG:g}\u00b0"))
    relative = max(_shares(document, "clock"), default=0.0)
    rate = f"; rate assumed correct, relative u = {relative:.1g}, a stated value" if relative else ""
    compared = "not compared with a reference here"
    if clock := procedure.get("clock"):
        off, std = clock["rate_ppm"], clock["std_ppm"]
        compared = f"deviation from GNSS time recorded with the counts {off:+.2g} ppm, u = {std:.2g} ppm"
    lines.append(("Time base", f"the device\u2019s own clock{rate}; {compared}"))
    return lines


def is_timed(document: Mapping[str, Any]) -> bool:
    """Say whether the device's clock was compared with a reference in the campaign of a calibration/1."""
    return "clock" in document["procedure"]


def _shares(document: Mapping[str, Any], source: str) -> list[float]:
    """Return a source's share of each scale factor's uncertainty, relative; of the others 0."""
    return [
        abs(part["std"] / one["value"]) if ".scale_factor." in one["name"] and one["value"] else 0.0
        for one in document.get("uncertainty", {}).get("parameters", ())
        for part in one.get("contributions", ())
        if part["source"] == source
    ]


def _digits(value: float, std: float) -> int:
    """Return the significant digits of a value that show two of its sigma."""
    return 2 if value == 0 else 2 + floor(log10(abs(value))) - floor(log10(std))


def _name(effect: str) -> str:
    return NAMES.get(effect, effect.replace(".", " ").replace("_", " "))
