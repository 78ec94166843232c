"""Knocks and wrong rows within soaks: short stretches that are livelier than the soak's own quiet.

They are looked for as in dwells (`procedures.anomalies.disturbances`), cut out and reported. What lasts longer, or
comes so often that little would be left, is a state of the soak and stays in: effects may go with it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.anomalies.channel_faults import changed_noise, clipped_channels, frozen_stretches
from procedures.anomalies.disturbances import (
    CHANNEL_LABELS,
    Disturbance,
    find_disturbances,
    rough_scale,
    without_disturbances,
)
from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.observations import channel
from procedures.counts.sample_records import Series
from procedures.frames import AXES, TRIADS
from procedures.inference import odds
from procedures.inference.marginal import log_mean
from procedures.inference.priors import PRESENT
from procedures.inference.result import EffectTest, Finding
from procedures.statistics.significance import STD_PER_MAD

SURROUNDINGS_S = 10.0  # either side of a stretch, against which it is held
MIN_SURROUNDINGS = 100  # samples
APART = 10  # the part of a stretch that is left between it and what it is held against
MIN_LIVELINESS = 1.5  # rms over that next to it, from which on a channel shows a disturbance
LOUD = 8.0  # sigma of a sample that is far off by itself
MAX_ROWS = 5  # far off, of a stretch that is wrong rows and no shock
ONE_NUMBER = 1e-3  # of how far it is off, within which it is one: less the line that goes on beneath it
TINY = 1e-300


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """A channel's samples (n,) in a stretch less their surroundings, over ``sigma`` of these [output].

    ``jump`` is the gain of a level that changes for good somewhere in the stretch, over one line throughout; none
    at the end of a recording.
    """

    channel: str
    samples: FloatArray
    sigma: float
    jump: float

    @property
    def is_lively(self) -> bool:
        """Say whether the stretch is livelier than what surrounds it."""
        return _rms(self.samples) > MIN_LIVELINESS

    @property
    def is_step(self) -> bool:
        """Say whether it does not come back: a jump is likelier than a shock.

        A shock is more scatter of the samples.
        """
        shock = float(odds.gain_of_squares(np.array(np.sum(self.samples**2)), len(self.samples)))
        found = odds.shares({"jump": odds.log_odds(self.jump), "shock": odds.log_odds(shock)})
        return found["jump"] >= PRESENT


def wrong_rows(found: Sequence[Deviation]) -> IntArray:
    """Return the rows (m,) of a stretch, from its first, that are far off where nothing else is lively.

    None where there are more than `MAX_ROWS`, which are not one number: then it is a shock.
    """
    samples = np.stack([each.samples for each in found], axis=1)
    is_far = np.max(np.abs(samples), axis=1) > LOUD
    is_quiet = all(_rms(each.samples[~is_far]) < MIN_LIVELINESS for each in found)
    loudest = samples[is_far][:, np.argmax(np.max(np.abs(samples), axis=0))]
    is_few = len(loudest) <= MAX_ROWS or float(np.ptp(loudest)) < ONE_NUMBER * float(np.max(np.abs(loudest)))
    return np.flatnonzero(is_far if is_quiet and is_few else np.zeros_like(is_far))


def _rms(samples: FloatArray) -> float:
    return float(np.sqrt(np.mean(samples**2))) if len(samples) else 0.0


def deviations_in(series: Series, found: Disturbance) -> list[Deviation]:
    """Return what every channel of a recording does in a disturbed stretch."""
    length = max(round(SURROUNDINGS_S / series.period), MIN_SURROUNDINGS)
    apart = (found.end - found.first) // APART  # the disturbance may go on a little beyond what was found of it
    before = slice(max(found.first - apart - length, 0), max(found.first - apart, 0))
    after = slice(found.end + apart, found.end + apart + length)
    reported = list[Deviation]()
    for triad in TRIADS:
        if (samples := channel(series, triad)) is None:
            continue
        for axis, name in enumerate(CHANNEL_LABELS[triad]):
            x = np.asarray(samples[:, axis], dtype=np.float64)
            reported.append(_deviation(name, x[before], x[found.first : found.end], x[after], apart))
    return reported


def _deviation(name: str, before: FloatArray, inside: FloatArray, after: FloatArray, apart: int) -> Deviation:
    """Hold a stretch's samples against a line of one slope, two levels, through those ``apart`` on either side."""
    t = np.arange(len(inside), dtype=np.float64)
    t_around = np.concatenate([np.arange(-len(before), 0) - apart, len(inside) + apart + np.arange(len(after))])
    A = np.stack([t_around < 0, t_around >= 0, t_around], axis=1).astype(np.float64)
    values = np.concatenate([before, after])
    R = np.linalg.pinv(A)
    first, last, slope = R @ values
    off = values - A @ [first, last, slope]
    sigma = STD_PER_MAD * float(np.median(np.abs(off))) or float(off.std()) or TINY  # a coarse, a dead channel
    if len(before) == 0 or len(after) == 0:
        line = (last if len(after) else first) + slope * t
        return Deviation(name, (inside - line) / sigma, sigma, -np.inf)
    every, begin = np.concatenate([t_around[: len(before)], t, t_around[len(before) :]]), len(before)
    jump = _gain_of_jump(every, np.concatenate([before, inside, after]) / sigma, slice(begin, begin + len(t) + 1))
    return Deviation(name, (inside - (first + last) / 2 - slope * t) / sigma, sigma, jump)


def _gain_of_jump(t: FloatArray, y: FloatArray, at: slice) -> float:
    """Return the gain of a jump of y (n,) [sigma] at any of some places, added to a line over t (n,) [sample]."""
    Q, _ = np.linalg.qr(np.stack((np.ones_like(t), t), axis=1))
    later = np.cumsum((y - Q @ (Q.T @ y))[::-1])[::-1][at]
    taken = np.sum(np.cumsum(Q[::-1], axis=0)[::-1][at] ** 2, axis=1)
    number = np.arange(len(t), 0, -1)[at]
    return float(log_mean(odds.gain_of_squares(later**2 / np.maximum(number - taken, TINY), 1)))


MAX_SHOCK_S = 30.0  # that is cut as one
MAX_CUT_SHARE = 0.2  # of a soak


@dataclass(frozen=True, slots=True, eq=False)
class QuietSoaks:
    """Campaigns whose soaks are without their shocks, what was found, and the test that was made."""

    campaigns: tuple[Campaign, ...]
    findings: tuple[Finding, ...]
    tests: tuple[EffectTest, ...]


def without_shocks(campaigns: Sequence[Campaign]) -> QuietSoaks:
    """Return one unit's campaigns with the short disturbed stretches of their soaks cut out."""
    soaks = [_of_soaks(campaign) for campaign in campaigns]
    frozen = list(frozen_stretches(soaks))
    alive = without_disturbances(soaks, frozen)
    found, tests = find_disturbances(alive, are_soaks=True)
    kept = list(_short(alive, found))
    quiet = without_disturbances(alive, kept)
    put_back = tuple(_put_back(one, other) for one, other in zip(campaigns, quiet, strict=True))
    reported = [*(each.finding for each in frozen), *_named(alive, kept)]
    lasting = [*clipped_channels(quiet), *(list(_states(alive, found)) or changed_noise(quiet))]
    return QuietSoaks(put_back, (*reported, *lasting), tests)


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
        each = max(stays, key=lambda one: one.log_odds)
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


def _is_short(rest: RestRecord, found: Disturbance) -> bool:
    return 0 < found.end - found.first <= MAX_SHOCK_S / rest.series.period


def _is_step(rest: RestRecord, found: Disturbance) -> bool:
    return found.end > found.first and any(one.is_step for one in deviations_in(rest.series, found))


def _named(soaks: Sequence[Campaign], kept: Sequence[Disturbance]) -> Iterator[Finding]:
    """Yield a finding for each of a soak's disturbances, the surest first."""
    for campaign, rest, here in _by_soak(soaks, kept):
        for each in sorted(here, key=lambda one: -one.log_odds):
            yield _finding_of(campaign, rest, each)


def _narrowed(rest: RestRecord, found: Disturbance) -> Disturbance:
    """Return a disturbance that is wrong rows as these alone: nothing about them is lost."""
    rows = wrong_rows(deviations_in(rest.series, found))
    if not len(rows):
        return found
    return replace(found, first=found.first + int(rows[0]), end=found.first + int(rows[-1]) + 1)


def _finding_of(campaign: Campaign, rest: RestRecord, found: Disturbance) -> Finding:
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
        unit=unit, where=where, shape="", fault="wrong row",
    )  # fmt: skip
