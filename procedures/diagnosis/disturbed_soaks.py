"""Knocks and wrong rows within soaks: short stretches that are livelier than the soak's own quiet.

They are looked for as in dwells (`procedures.diagnosis.disturbances`), cut out and said. What lasts longer, or
comes so often that little would be left, is a state of the soak and stays in: effects may go with it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.campaign.campaign import Campaign, RestRecord
from procedures.diagnosis.changed_noise import changed_noise
from procedures.diagnosis.clipped_channels import clipped_channels
from procedures.diagnosis.disturbances import (
    CHANNEL_LABELS,
    Disturbance,
    find_disturbances,
    rough_scale,
    without_disturbances,
)
from procedures.diagnosis.disturbed_channels import TINY, deviations_in, wrong_rows
from procedures.diagnosis.frozen_channels import frozen_stretches
from procedures.diagnosis.result import EffectTest, Finding
from procedures.frames import AXES

MAX_KNOCK_S = 30.0  # that is cut as one
MAX_CUT_SHARE = 0.2  # of a soak
MAX_NAMED = 3  # of a soak, each for itself; of more the surest, and how many others there are


@dataclass(frozen=True, slots=True, eq=False)
class QuietSoaks:
    """Campaigns whose soaks are without their knocks, what was found, and the test that was made."""

    campaigns: tuple[Campaign, ...]
    findings: tuple[Finding, ...]
    tests: tuple[EffectTest, ...]


def without_knocks(campaigns: Sequence[Campaign]) -> QuietSoaks:
    """Return one unit's campaigns with the short disturbed stretches of their soaks cut out."""
    soaks = [_of_soaks(campaign) for campaign in campaigns]
    frozen = list(frozen_stretches(soaks))
    alive = without_disturbances(soaks, frozen)
    found, tests = find_disturbances(alive, are_soaks=True)
    kept = list(_short(alive, found))
    quiet = without_disturbances(alive, kept)
    put_back = tuple(_put_back(one, other) for one, other in zip(campaigns, quiet, strict=True))
    told = [*(each.finding for each in frozen), *_named(alive, kept)]
    lasting = [*clipped_channels(quiet), *(list(_states(alive, found)) or changed_noise(quiet))]
    return QuietSoaks(put_back, (*told, *lasting), tests)


def _of_soaks(campaign: Campaign) -> Campaign:
    """Return a campaign whose soaks are its rests, and which has nothing else."""
    rests = tuple(RestRecord(soak.name, soak.up, soak.series) for soak in campaign.soaks)
    return replace(campaign, dwells=(), turns=(), rests=rests, soaks=(), moves=(), sequences=())


def _put_back(campaign: Campaign, quiet: Campaign) -> Campaign:
    soaks = zip(campaign.soaks, quiet.rests, strict=True)
    return replace(campaign, soaks=tuple(replace(soak, series=rest.series) for soak, rest in soaks))


def _short(soaks: Sequence[Campaign], found: Sequence[Disturbance]) -> Iterator[Disturbance]:
    """Yield what is short and comes back to where it began, of soaks of which most is quiet."""
    for _, rest, here in _by_soak(soaks, found):
        yield from _cut_of(rest, here)


def _cut_of(rest: RestRecord, here: Sequence[Disturbance]) -> list[Disturbance]:
    """Return what is to be cut out of a soak; nothing where that were too much of it."""
    short = [_narrowed(rest, each) for each in here if _is_short(rest, each) and not _is_step(rest, each)]
    return short if sum(each.end - each.first for each in short) <= MAX_CUT_SHARE * len(rest.series) else []


def _states(soaks: Sequence[Campaign], found: Sequence[Disturbance]) -> Iterator[Finding]:
    """Yield what lasts, or comes so often that it stays in, the surest of each soak and how many others there are.

    Of one sensor alone it may be its own noise.
    """
    for _, rest, here in _by_soak(soaks, found):
        is_cut = bool(_cut_of(rest, here))
        stays = [each for each in here if not _is_step(rest, each) and not (is_cut and _is_short(rest, each))]
        if not stays:
            continue
        each = min(stays, key=_log_p)
        lively = [one for one in deviations_in(rest.series, each) if one.is_lively]
        triad = "accelerometer" if each.finding.unit == "g" else "gyroscope"
        others: dict[str, object] = {"others": len(stays) - 1} if len(stays) > 1 else {}
        finding = replace(each.finding, where={**each.finding.where, **others})
        own = finding.or_else(f"{triad}.noise")
        yield finding if len(lively) > 1 else own


def _by_soak(
    soaks: Sequence[Campaign], found: Sequence[Disturbance]
) -> Iterator[tuple[Campaign, RestRecord, list[Disturbance]]]:
    for number, campaign in enumerate(soaks):
        for step, rest in enumerate(campaign.rests):
            yield campaign, rest, [each for each in found if (each.campaign, each.step) == (number, step)]


def _log_p(found: Disturbance) -> float:
    return 0.0 if found.finding.log_p is None else found.finding.log_p


def _is_short(rest: RestRecord, found: Disturbance) -> bool:
    return 0 < found.end - found.first <= MAX_KNOCK_S / rest.series.period


def _is_step(rest: RestRecord, found: Disturbance) -> bool:
    return found.end > found.first and any(one.is_step for one in deviations_in(rest.series, found))


def _named(soaks: Sequence[Campaign], kept: Sequence[Disturbance]) -> Iterator[Finding]:
    """Yield a finding for each of a soak's disturbances, of many the surest for all."""
    for campaign, rest, here in _by_soak(soaks, kept):
        here.sort(key=_log_p)
        others: dict[str, object] = {"others": len(here) - 1} if len(here) > MAX_NAMED else {}
        for each in here[: 1 if others else MAX_NAMED]:
            finding = _told(campaign, rest, each)
            yield replace(finding, where={**finding.where, **others})


def _narrowed(rest: RestRecord, found: Disturbance) -> Disturbance:
    """Return a disturbance that is wrong rows as these alone: nothing about them is lost."""
    rows = wrong_rows(deviations_in(rest.series, found))
    if not len(rows):
        return found
    return replace(found, first=found.first + int(rows[0]), end=found.first + int(rows[-1]) + 1)


def _told(campaign: Campaign, rest: RestRecord, found: Disturbance) -> Finding:
    """Return the finding of a disturbance; of one that is a row or two by how far these are off.

    What one sensor alone shows for longer may be its own: noise that switches between two levels does so.
    """
    finding, seen = found.finding, deviations_in(rest.series, found)
    if not len(rows := wrong_rows(seen)):
        triad = "accelerometer" if finding.unit == "g" else "gyroscope"
        is_alone = sum(each.is_lively for each in seen) == 1
        return finding.or_else(f"{triad}.jump") if is_alone else finding
    loudest = max(seen, key=lambda each: float(np.max(np.abs(each.samples[rows]))))
    triad = next(triad for triad, names in CHANNEL_LABELS.items() if loudest.channel in names)
    k = rough_scale(campaign, triad) * (rest.series.period if campaign.counts else 1.0)
    at = int(rows[np.argmax(np.abs(loudest.samples[rows]))])
    of_triad = [each for each in seen if each.channel in CHANNEL_LABELS[triad]]
    sigma = np.array([one.sigma for one in of_triad])
    off = sigma * [one.samples[at] for one in of_triad]
    where = {"file": rest.name, "channel": loudest.channel, "at_s": float(rest.series.t[found.first + at])}
    unit, alive = "g" if triad == "accelerometer" else "deg/h", np.flatnonzero(sigma > TINY)
    return replace(
        finding, coefficients=tuple(AXES[axis] for axis in alive), value=(off / k)[alive], std=(sigma / k)[alive],
        unit=unit, where=where, shape="a wrong row",
    )  # fmt: skip
