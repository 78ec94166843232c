"""Whether a campaign confirms an effect that a search proposed: only data that had no part in finding it does."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from procedures.statistics.tail_probabilities import log_chi2_sf
from station.files.effect_file import EffectFile

PROPOSED = "proposed"
LEFT = ("unexplained", "partly")  # verdicts that leave more than noise: a reading that is not the law does
MAX_LOG_P = np.log(0.01)  # of coefficients of nought


def confirms(
    document: Mapping[str, Any], entry: Mapping[str, Any], campaigns: Sequence[str], found_in: Sequence[str]
) -> bool:
    """Say whether a `diagnosis/1` with an effect in its model from the start confirms it.

    Its campaigns had no part in finding it, its coefficients are not nought, and with it noise is what is left.
    ``entry`` is the solution's of the effect, ``found_in`` the campaigns of its origin.
    """
    if set(campaigns) & set(found_in) or document.get("verdict") in LEFT or "coefficients" not in entry:
        return False
    shape = entry.get("units", {})
    sigmas = [one["value"] / one["std"] for name, one in entry["coefficients"].items() if name not in shape]
    return bool(sigmas) and log_chi2_sf(float(np.sum(np.square(sigmas))), len(sigmas)) < MAX_LOG_P


def confidence_text(file: EffectFile) -> str:
    """Return how sure an adopted effect is; nothing of one that no search found."""
    if file.is_only_proposed:
        return (
            "proposed: no data but those it was found in show it; diagnose a later campaign with --effects and "
            "adopt it from there"
        )
    if file.origin is not None and file.origin.confidence:
        return f"confirmed by {', '.join(file.origin.confirmed_by)}"
    return ""
