"""Dwells of a campaign that contradict each other or the cube's certificate, or were kept with a tilted cube."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from procedures.bench.seating_check import PLAUSIBLE_FACE_TILT_RAD
from procedures.campaign.plan_steps import Dwell
from procedures.units import RAD_PER_ARCSEC
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.stream.recorder.accepted_step_writer import step_of

OF_DWELLS = "accelerometer dwells"
IN_DOUBT = {"ambiguous", "partly", "unexplained"}
FACE_TILT = "fixture.face_tilt"
OF_FACES = {"fixture.parallelism", FACE_TILT}
QUADRATIC, SEAT = "accelerometer.quadratic", "placement.dwell"
UNEXPLAINED = {"partly", "unexplained"}
FAR_BEYOND_NOISE = 5.0  # times its noise, rms of a step's rows: scatter of all steps alike does not stand out so
SURE_SIGMAS = 2.0  # by which a tilt must be beyond what a cube's own face has


def contradiction_of(document: Mapping[str, Any], *, is_certified: bool = False) -> str:
    """Return what a verdict must say first where dwells contradict each other and no cause is known.

    Their error before anything was added to the model, in g, is the tilt [rad] of a cube that would do the same: a
    cube's own faces are not tilted by more than `PLAUSIBLE_FACE_TILT_RAD`. A model that is then made to fit
    assigns the tilt to bench or sensor, and neither its sigmas nor the limits reveal it. The same holds for a
    seating that is off by more. Empty where they do not contradict, or where the diagnosis knows
    why, and that is not a face tilted as none is. ``document`` is a ``diagnosis/2``; where the cube
    ``is_certified``, all six faces of it, its faces may not be off at all.

    Nor is a step relied on that is far beyond its noise where nothing explains it: uncertainty takes what is left
    for scatter of all steps, which a single one may exceed.
    """
    off = max(_beyond_any_face(document), default=0.0)
    if document["verdict"] not in IN_DOUBT and not off:
        return ""
    off = max(off, 0.0, *(each["before"] for each in document["error"] if each["quantity"] == OF_DWELLS))
    if off > PLAUSIBLE_FACE_TILT_RAD:
        return (
            f"do not use this result: the dwells contradict each other by {np.degrees(off):.2g} deg (possibly "
            f"debris under the cube, or a position with a wrong label)"
        )
    off = max(_off_certificate(document), default=0.0) if is_certified else 0.0
    return _certificate_in_words(off) if off else _step_in_words(document)


def _beyond_any_face(document: Mapping[str, Any]) -> Iterator[float]:
    """Yield tilts [rad] that are surely larger than those of a cube's own faces, however sure the diagnosis is.

    Where some faces stood once, their tilts and the misalignments hardly know each other: two cubes that are
    tilted, also about the vertical, then fit with faces tilted by a third of a degree and a residual of nothing.
    """
    for finding in document["findings"]:
        if finding["effect"] in {FACE_TILT, SEAT}:
            for each in finding["coefficients"].values():
                if abs(each["value"]) - SURE_SIGMAS * each["std"] > PLAUSIBLE_FACE_TILT_RAD:
                    yield abs(each["value"])


def _off_certificate(document: Mapping[str, Any]) -> Iterator[float]:
    """Yield by how much [rad] faces would be off their certificate, where a seating could be off instead.

    One seating that is off changes misalignment by half of it, two tilted faces do not change it: which of them
    it was is not determined. A sensor that is not linear looks like faces that are off alike along its axis; what
    is not alike, which is ``where`` a finding has a channel, is no sensor's.
    """
    for finding in document["findings"]:
        is_sensor = QUADRATIC in finding["aliases"] and "channel" not in finding["where"]
        if finding["effect"] in OF_FACES and finding["confidence"] == "possible" and not is_sensor:
            yield max(abs(each["value"]) for each in finding["coefficients"].values())


def _step_in_words(document: Mapping[str, Any]) -> str:
    """Name the step that is farthest beyond its noise, if it is far and no cause is known; else say nothing."""
    if document["verdict"] not in UNEXPLAINED:
        return ""
    steps = (each for each in document.get("left", ()) if each["by"] == "step")
    worst = max(steps, key=lambda each: float(each["size"]), default=None)
    if worst is None or worst["size"] < FAR_BEYOND_NOISE:
        return ""
    return (
        f"do not use this result: the error of {worst['what']} is {worst['size']:.2g} times its noise, and the "
        f"cause is unknown; record it again"
    )


def _certificate_in_words(off: float) -> str:
    size = f"{off / RAD_PER_ARCSEC:.0f} arcsec" if off < PLAUSIBLE_FACE_TILT_RAD else f"{np.degrees(off):.2g} deg"
    return (
        f"do not use this result: the dwells disagree with the face certificate by {size} (possibly debris under "
        f"the cube, position unknown); record both positions of every face again"
    )


def kept_tilted_dwells(tables: CampaignTable) -> list[tuple[Dwell, float]]:
    """Return the dwells that were kept though the cube was tilted, by how far [rad], the worst first."""
    off = [
        (step, float(np.linalg.norm(dwell.kept_seat_rad)))
        for dwell in tables.dwell
        if dwell.kept_seat_rad is not None and isinstance(step := step_of(dwell), Dwell)
    ]
    return sorted(off, key=lambda each: each[1], reverse=True)


def worst_kept(tables: CampaignTable) -> str:
    """Return the name of the kept step with the largest tilt, empty if there is none."""
    return next((step.name for step, _ in kept_tilted_dwells(tables)), "")


def kept_tilt_warning(tables: CampaignTable) -> str:
    """Return what a verdict must say first where a kept dwell is tilted by more than a cube's own faces may be.

    Such a step stands in the fit as if it were level, and the limits do not reveal it. Empty where there is none.
    """
    bad = {step: off for step, off in kept_tilted_dwells(tables) if off > PLAUSIBLE_FACE_TILT_RAD}
    if not bad:
        return ""
    which = " and ".join(f"position {step.words}" for step in sorted(bad, key=lambda each: each.name))
    return (
        f"do not use this result, record {which} again: it was kept although the cube was tilted by "
        f"{'up to ' if len(bad) > 1 else ''}{np.degrees(max(bad.values())):.2g} deg"
    )
