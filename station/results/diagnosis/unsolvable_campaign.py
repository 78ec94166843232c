"""What can be reported of a campaign that determines no triad: how level its faces stood.

The mean accelerometer output of a dwell with a known face up points along the up vector, if scale factors agree
and biases are small compared with 1 g. Its components along the two other cube axes over that along the vertical
are the tilt, in which bias / 1 g and misalignment are. No scale factor is needed for a ratio.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RateTable
from procedures.counts.sample_records import CountSeries, Series
from procedures.diagnosis.single_channels import MIN_RECORDING_SAMPLES
from procedures.errors import NotObservable
from procedures.evidence.rate_points import LEAST_POINTS, LEAST_SPAN
from procedures.evidence.thermal_soaks import BLOCK_S, MIN_BLOCKS, SAMPLES_PER_BLOCK
from procedures.frames import AXES
from procedures.positions import cross_axes, face_normal, face_of
from procedures.samples.held_samples import constant_channels, records_at_rest
from procedures.statistics.spectrum import MIN_SAMPLES
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis.diagnosis_json import FORMAT
from station.results.diagnosis.log_measurements import recording_of
from station.results.diagnosis.uncalibrated import channels_of, rests_and_moves, turns, without_solution

ALSO_IN_A_TILT = ("accelerometer.bias", "accelerometer.misalignment", "slab.tilt", "placement.dwell")
ASSUMED_STD = 2e-3  # rad, u of bias over 1 g, misalignment and unequal scale factors that are in a tilt
MAX_TILT = 0.5  # rad: beyond, the vertical is not where the face says


def partial_document(campaigns: Sequence[LoadedCampaign], missing: NotObservable) -> dict[str, Any] | None:
    """Return what can be reported as `diagnosis/2`, None if nothing can; ``missing`` says what stays open."""
    tilts = [found for loaded in campaigns for found in levelling(loaded.campaign)]
    channels = channels_of(campaigns, ())
    recorded = [loaded.campaign for loaded in campaigns]
    moved = rests_and_moves(recorded) | turns(recorded)
    if not tilts and not channels and not moved:
        return None
    needed = _next_of(recorded, missing)
    return {
        "format": FORMAT,
        "recording": recording_of(campaigns),
        "verdict": "ambiguous",
        "findings": [_finding(name, face, tilt, needed) for name, face, tilt in tilts],
        "error": [],
        "parameters": [],
        **without_solution(campaigns),
        "tests": [],
        "next_measurement": needed,
        **moved,
        **({"channels": channels} if channels else {}),
    }  # fmt: skip


def _next_of(campaigns: Sequence[Campaign], missing: NotObservable) -> str:
    """Return what to measure next: of recordings without positions not the twelve positions of a cube."""
    if any(campaign.dwells or campaign.rests or campaign.sequences for campaign in campaigns):
        return ", ".join(missing.missing)
    poses = "a log of rests on all six faces, or in ten attitudes, moved by hand in between, for accelerometers"
    turns = "whole turns about each axis, both ways, for gyroscopes (or --reference of a rate table)"
    longer = f"{MIN_BLOCKS * SAMPLES_PER_BLOCK} samples or {2 * BLOCK_S:g} s at rest for what moves within it"
    is_short = any(campaign.soaks for campaign in campaigns)
    return "; ".join((longer, poses, turns) if is_short else (poses, turns))


class NothingShown(NotObservable):
    """Logs of which not even `partial_document` has a word."""

    def __init__(self, names: str, found: str, expected: str, remedy: str) -> None:
        super().__init__(f"anything of {names}", (expected,))
        self.args = (f"{names}: found {found}, expected {expected}; {remedy}",)


def nothing_at_all(campaigns: Sequence[LoadedCampaign], missing: NotObservable) -> NotObservable:
    """Return what to say where not even `partial_document` has a word: what rests or a table need."""
    if any(loaded.campaign.dwells or loaded.campaign.turns or loaded.campaign.sequences for loaded in campaigns):
        return missing
    names = ", ".join(step.table.file for loaded in campaigns for step in loaded.steps)
    if tables := [table for loaded in campaigns for table in loaded.campaign.rate_tables]:
        found = "; ".join(_points(table) for table in tables)
        needed = f"{LEAST_POINTS} points at rates that differ by more than {100 * LEAST_SPAN:g} %, rest among them"
        return NothingShown(names, found, needed, "record more rates, or name another column as --reference")
    dead = constant_channels(records_at_rest([loaded.campaign for loaded in campaigns]))
    if dead and not channels_of(campaigns, ()):
        found = f"outputs that never change ({', '.join(dead)})"
        return NothingShown(names, found, "an output that does", "check the unit, or name other columns")
    rests = [soak.series for loaded in campaigns for soak in loaded.campaign.soaks]
    longest = max((len(series) for series in rests), default=0)
    moves = MIN_BLOCKS * SAMPLES_PER_BLOCK
    needed = f"{MIN_RECORDING_SAMPLES} for drift, {MIN_SAMPLES} for noise, {moves} for what moves within"
    return NothingShown(
        names, f"{longest} samples at rest", needed, "record longer, or state with --as what it is"
    )


def _points(table: RateTable) -> str:
    fastest = float(np.max(np.abs(table.reference)))
    span = 100 * float(np.ptp(table.reference)) / fastest if fastest > 0 else 0.0
    return f"{len(table.reference)} points at rates that differ by {span:.3g} % about {table.axis}"


def levelling(campaign: Campaign) -> Iterator[tuple[str, str, FloatArray]]:
    """Yield name, face and tilt (2,) [rad] along the two other cube axes of every known face."""
    dwells = [(d.name, face_of(d.position), d.series) for d in campaign.dwells]
    dwells += [(r.name, r.up, r.series) for r in campaign.rests if r.up is not None]
    for name, face, series in dwells:
        if (mean := _mean_output(series)) is None:
            continue
        output = campaign.fixture.C_sb.T @ mean
        vertical = float(output @ face_normal(face))
        across = output[list(cross_axes(face))]
        if vertical > 0 and np.linalg.norm(across) < MAX_TILT * vertical:
            yield name, face, across / vertical


def _mean_output(series: Series) -> FloatArray | None:
    """Return the accelerometers' mean output (3,) over the whole recording, None if they are absent."""
    if series.accel is None:
        return None
    mean: FloatArray = np.asarray(series.accel, dtype=np.float64).mean(axis=0)
    return mean / series.period if isinstance(series, CountSeries) else mean


def _finding(name: str, face: str, tilt: FloatArray, needed: str) -> dict[str, Any]:
    return {
        "effect": "fixture.face_tilt",
        "kind": "bench",
        "coefficients": {
            f"{face}.{AXES[i]}": {"value": float(v), "std": ASSUMED_STD}
            for i, v in zip(cross_axes(face), tilt, strict=True)
        },
        "unit": "rad",
        "where": {"file": name},
        "levelling_deg": float(np.degrees(np.arctan(np.linalg.norm(tilt)))),
        "confidence": "possible",
        "probability": 0.5,
        "aliases": list(ALSO_IN_A_TILT),
        "separate_by": needed,
    }
