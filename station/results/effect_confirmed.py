"""Whether a campaign confirms an effect that a search proposed: only data that had no part in finding it does."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from procedures.statistics.significance import log_chi2_sf
from station.files.effect_file import DIGITS, EffectFile, OriginTable

PROPOSED = "proposed"
LEFT = ("unexplained", "partly")  # verdicts that leave more than noise: a reading that is not the law does
MAX_LOG_P = np.log(0.01)  # of coefficients of nought


def recordings(document: Mapping[str, Any]) -> list[str]:
    """Return the first digits of the hash of every recording of a `diagnosis/2`: the same in whatever folder."""
    return sorted({sha256[:DIGITS] for name, sha256 in _files(document).items() if not name.endswith(".toml")})


def why_not_confirmed(document: Mapping[str, Any], entry: Mapping[str, Any], origin: OriginTable) -> str:
    """Return why a `diagnosis/2` with an effect in its model from the start does not confirm it, empty if it does.

    None of its recordings may have had a part in finding it, its coefficients must differ from nought, and noise
    be what is left with it. ``entry`` is the solution's of the effect.
    """
    # two campaigns by one plan have one campaign.toml: it tells only where an origin names no recordings
    tomls = set[str]() if origin.data else {said.split()[-1] for said in origin.campaigns}
    if set(recordings(document)) & set(origin.data) or set(_files(document).values()) & tomls:
        return "it was found in some of these recordings"
    if "coefficients" not in entry:
        return "the diagnosis proposes it, but its model did not include it from the start"
    if document.get("verdict") in LEFT:
        return f"with it in the model the verdict is {document['verdict']}"
    shape = entry.get("units", {})
    sigmas = [one["value"] / one["std"] for name, one in entry["coefficients"].items() if name not in shape]
    if not sigmas or log_chi2_sf(float(np.sum(np.square(sigmas))), len(sigmas)) >= MAX_LOG_P:
        return "its coefficients do not differ from zero here"
    return ""


def _files(document: Mapping[str, Any]) -> dict[str, str]:
    origin = document.get("solution", document).get("provenance", {})
    return {str(name): str(sha256) for name, sha256 in origin.get("files", {}).items()}


def confidence_text(file: EffectFile, why: str = "") -> str:
    """Return how sure an adopted effect is, and ``why`` not surer; nothing of one that no search found."""
    if file.is_only_proposed:
        why = why or "only the data in which it was found show it"
        return f"proposed: {why}; diagnose a later campaign with --effects and adopt it from there"
    if file.origin is not None and file.origin.confidence:
        return f"confirmed by {', '.join(file.origin.confirmed_by)}"
    return ""
