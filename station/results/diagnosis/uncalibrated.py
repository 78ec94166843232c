"""What a `diagnosis/2` says in place of a solution, where recordings determine no calibration."""

from collections.abc import Mapping, Sequence
from typing import Any

from procedures.effects.effect import UNITS_OF_NONLINEAR
from procedures.frames import TRIADS
from procedures.units import DEG_H_PER_DEG_S
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.files.effect_file import stored_effect
from station.results.solution_json import provenance

OUTPUT = "output"  # the unit of a triad whose unit nobody told
PARTS = ("scale_factor", "misalignment", "bias")
_SIZES = ("value", "std", "before", "after", "held_out_before", "held_out_after")


def without_solution(campaigns: Sequence[LoadedCampaign]) -> dict[str, Any]:
    """Return what stays open, the recordings' warnings and where they come from."""
    warnings = list(dict.fromkeys(w for loaded in campaigns for w in loaded.warnings))
    return {
        "not_observable": [f"{triad}.{part}" for triad in TRIADS for part in PARTS],
        "warnings": warnings,
        "provenance": provenance(campaigns),
    }


def in_told_unit(part: Mapping[str, Any], of: str, told: Mapping[str, float]) -> dict[str, Any]:
    """Return a finding or an error in outputs where its triad's unit is not among the ``told``.

    Without one the outputs were taken for g and deg/s; ``of`` begins with the triad's name.
    """
    triad = next((name for name in TRIADS if of.startswith(name)), None)
    head, slash, rest = part["unit"].partition("/")
    if triad is None or triad in told or head not in {"g", "deg"}:
        return dict(part)
    factor = 1.0
    if head == "deg" and (rest == "h" or rest.startswith("h/")):  # deg/h, deg/h/K; an output counts as deg/s
        factor, rest = 1 / DEG_H_PER_DEG_S, rest.removeprefix("h").removeprefix("/")
        slash = "/" if rest else ""
    return _times(part, factor, _parameters(part)) | {"unit": f"{OUTPUT}{slash}{rest}"}


def _parameters(part: Mapping[str, Any]) -> frozenset[str]:
    """Return what is fitted beside coefficients, in a unit of its own."""
    if "definition" not in part:
        return frozenset(UNITS_OF_NONLINEAR)
    return frozenset(stored_effect(part["definition"], part["sha256"], part["effect"]).term.parameters)


def _times(part: Mapping[str, Any], factor: float, kept: frozenset[str] = frozenset()) -> dict[str, Any]:
    return {
        name: {key: dict(one) if key in kept else _times(one, factor) for key, one in value.items()}
        if name == "coefficients"
        else value * factor
        if name in _SIZES
        else value
        for name, value in part.items()
    }
