"""The effects of a `calibration/1`: which can be taken off a sample, and what each needs to be known."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from procedures.effects import EFFECTS
from procedures.effects.effect import PLAY, TAU, Effect
from procedures.effects.term.inputs import AUXILIARY
from station.calibrated.compiled_effects import is_compiled, signals_of
from station.calibrated.surroundings import Surroundings
from station.errors import DataRefused
from station.files.effect_file import EffectFile, stored_effect

TRANSIENT_EFFECTS = (
    "accelerometer.bias_drift", "gyroscope.bias_drift", "accelerometer.relaxation",
    "accelerometer.bias_settling", "gyroscope.bias_settling", "accelerometer.scale_settling",
    "gyroscope.scale_settling",
)  # fmt: skip
LOST = ("gyroscope.counts_lost",)
CATALOGUE: Mapping[str, Effect] = {effect.name: effect for effect in EFFECTS}


def left_for_good(entry: Mapping[str, Any]) -> str:
    """Return why an effect is never taken off, empty if it may be; raises as `own_effect`."""
    name = str(entry["name"])
    if "definition" in entry:
        if own_effect(entry).term.looks_back:
            return "specific to the campaign or to earlier steps; one sample does not determine it"
        return ""
    if name in TRANSIENT_EFFECTS:
        return "specific to the campaign, not a constant of the instrument"
    if name not in CATALOGUE:
        return "not in this program's catalogue"
    if name in LOST:
        return "counts lost above a rate cannot be restored"
    if not is_compiled(entry):
        return "specific to the campaign; one sample does not determine it"
    if not all(tau > 0 for tau in temperature_lags(entry)):
        return "a time constant that is not above zero"
    return "" if all(width > 0 for width in plays(entry)) else "a backlash that is not above zero"


def needs(entry: Mapping[str, Any], around: Surroundings, triads: set[str]) -> str:
    """Return what an effect lacks in the surroundings, empty if it lacks nothing."""
    name = str(entry["name"])
    if name.split(".")[0] not in triads:
        return ""
    return "the quantity that it depends on was not recorded" if _lacks(entry, around, triads) else ""


def _lacks(entry: Mapping[str, Any], around: Surroundings, triads: set[str]) -> bool:
    signals = around.followed
    if "definition" in entry:
        return any(not _is_known(name, around, triads) for name in own_effect(entry).term.inputs)
    name = str(entry["name"])
    if name == "gyroscope.magnetic":
        return around.magnetic is None or not np.isfinite(around.magnetic).any()
    if name == "gyroscope.g_sensitivity":
        return "accelerometer" not in triads
    return any(not np.isfinite(signals.of(signal)).any() for signal in signals_of(entry))


def _is_known(name: str, around: Surroundings, triads: set[str]) -> bool:
    """Say whether an input of a term is known at any sample."""
    signals = around.followed
    word = name.partition("_")[0]
    if word == "aux":
        value = around.auxiliary.get(name.removeprefix(AUXILIARY))
        return value is not None and bool(np.isfinite(value).any())
    if word == "B":
        return around.magnetic is not None and bool(np.isfinite(around.magnetic).any())
    if word == "T":
        return bool(np.isfinite(signals.rate if name == "T_rate" else signals.warmth).any())
    of_triad = {"f": "accelerometer", "omega": "gyroscope"}
    return of_triad.get(word, next(iter(triads))) in triads


def temperature_lags(entry: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the time constants [s] by which an effect follows the temperature."""
    values = {name: float(one["value"]) for name, one in entry.get("coefficients", {}).items()}
    if "definition" not in entry:
        return (values[TAU],) if TAU in values else ()
    term = own_effect(entry).term
    return term.temperature_lags({name: values[name] for name in term.parameters})


def plays(entry: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the half widths [K] with which an effect of the catalogue follows the temperature with a play."""
    play = None if "definition" in entry else entry.get("coefficients", {}).get(PLAY)
    return () if play is None else (float(play["value"]),)


def own_effect(entry: Mapping[str, Any]) -> EffectFile:
    """Return the `effect/1` of an entry that has one.

    Raises
    ------
    DataRefused
        If it is not what was stored, or a parameter of its term has no value.
    """
    name = str(entry["name"])
    found = stored_effect(str(entry["definition"]), str(entry.get("sha256", "")), name)
    if entry.get("unit", found.term.unit) != found.term.unit:
        raise DataRefused(f"effects.{name}", None, f"unit {entry['unit']!r}", f"{found.term.unit!r}, its term's")
    for parameter in found.term.parameters:
        if parameter not in entry.get("coefficients", {}):
            expected = "a value of every parameter of its term"
            raise DataRefused(f"effects.{name}", None, f"no value of {parameter}", expected, "solve it again")
    return found
