"""What stands in a `diagnosis/2` beside its findings: the noise at rest, and how what is left widens U."""

from collections.abc import Sequence
from typing import Any

from procedures.inference.result import Diagnosis
from procedures.samples.channel_noise import channel_noise
from procedures.samples.held_samples import known_scales
from procedures.uncertainty.budget import ParameterBudget, budget
from procedures.uncertainty.sources import GivenValues
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.noise.noise_json import channel_document

MAX_WIDENED = 6
MIN_GROWTH = 1.01  # of U, from which on a parameter is told


def beside_findings(campaigns: Sequence[LoadedCampaign], found: Diagnosis | None) -> dict[str, Any]:
    """Return ``noise``, as the channels of `noise/1`, and ``widened``; each left out where there is none."""
    bare = [one.campaign for one in campaigns]
    scales = known_scales(bare, None if found is None else found.solution)
    noise = [channel_document(each) for each in channel_noise(bare, scales)]
    widened = [] if found is None else _widened(found)
    return {name: part for name, part in (("noise", noise), ("widened", widened)) if part}


def _widened(found: Diagnosis) -> list[dict[str, Any]]:
    """Return the parameters whose expanded uncertainty what is left widens most, the worst first."""
    if found.unexplained is None or not (found.solution.accelerometer or found.solution.gyroscope):
        return []
    given = GivenValues() if found.clock is None else GivenValues(clock=found.clock)
    without = {each.name: each for each in budget(found.after, given)}
    left = GivenValues(unexplained=found.unexplained, clock=given.clock)
    pairs = [(without[each.name], each) for each in budget(found.after, left)]
    grown = [pair for pair in pairs if pair[1].expanded > MIN_GROWTH * pair[0].expanded]
    worst = sorted(grown, key=lambda pair: -pair[1].expanded / max(pair[0].expanded, 1e-300))
    return [_document(*pair) for pair in worst[:MAX_WIDENED]]


def _document(without: ParameterBudget, one: ParameterBudget) -> dict[str, Any]:
    return {
        "name": one.name, "unit": one.unit, "expanded_without": without.expanded, "expanded": one.expanded
    }  # fmt: skip
