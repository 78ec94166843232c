"""Dwells of a campaign that contradict each other by more than a bench does."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from procedures.bench.seating_check import PLAUSIBLE_FACE_TILT_RAD

OF_DWELLS = "accelerometer dwells"
IN_DOUBT = {"ambiguous", "partly", "unexplained"}


def contradiction_of(document: Mapping[str, Any]) -> str:
    """Return what a verdict must say first where dwells contradict each other and no cause is known.

    Their error before anything was added to the model, in g, is the tilt [rad] of a cube that would do the same: a
    cube's own faces are not tilted by more than `PLAUSIBLE_FACE_TILT_RAD`. A model that is then made to fit takes
    the tilt for the bench's or the sensor's, and neither its sigmas nor the limits can tell. Empty where they do
    not, or where the diagnosis knows why. ``document`` is a ``diagnosis/1``.
    """
    off = max((each["before"] for each in document["error"] if each["quantity"] == OF_DWELLS), default=0.0)
    if document["verdict"] not in IN_DOUBT or off <= PLAUSIBLE_FACE_TILT_RAD:
        return ""
    return (
        f"do not rely on it: the dwells contradict each other by {np.degrees(off):.2g} deg, as when the cube "
        f"stood on something, or in another position than was recorded"
    )
