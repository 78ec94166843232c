"""Which unit a time column is in: the posterior of every unit, by all evidence at once (Bayes' rule).

Each unit makes another sample rate of the same stamps. What is weighed: how common the unit is, the unit that the
name states, a scale in the file's header, a second clock in the file, the rate that was stated, the range of
stamps that count from a date, how many decimals they have, and the rates that inertial sensors are sampled at.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.time_unit import DAY_S, TIME_UNITS, TimeUnit, is_clock, minute_jumps

WINNING_ODDS = 100.0  # against the next: a wrong unit costs more than some ten questions, and the priors are rough
LIE_ODDS = 1e4  # a header that states a unit is wrong once in so many logs
POSSIBLE_HZ = (1e-4, 1e5)  # rates of any recording: a stated unit outside it is refused
OFFERED_HZ = (0.05, 2.5e4)  # rates of inertial sensors, 0.1 Hz to 20 kHz, with their tolerances
EVIDENCE_ROWS = 2000  # rows that are looked at, so that a streamed log is read as a whole one is
MAX_DECIMALS = 9
ROUNDED_SHARE = 0.05  # of the steps: rarer ones of two counts are gaps
EVIDENCE_RISES = 20  # steps that these rows must hold, where many rows share a stamp

# Density of sample rates per factor e, log-linear between these points: shares of public recordings by decade.
_SMOOTH_HZ = np.array([1e-4, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0, 8000.0, 2e4, 1e5])
_SMOOTH = np.array([1e-7, 2e-3, 0.03, 0.06, 0.12, 0.14, 0.12, 0.05, 0.01, 1e-7])
NOMINAL_HZ = np.array([
    1 / 10, 1 / 8, 1 / 6, 1 / 5, 1 / 4, 1 / 3, 1 / 2, 1, 2, 4, 5, 10, 12.5, 20, 25, 26, 50, 52, 100, 102.4, 104,
    125, 128, 200, 204.8, 208, 250, 256, 400, 416, 500, 512, 800, 833, 1000, 1600, 1666, 2000, 3200, 4000, 6400,
    8000,
])  # fmt: skip
"""Output data rates of IMUs. 60 and 120 Hz are left to the smooth part: they are 1 and 2 Hz in minutes."""
NOMINAL_SHARE = 0.6  # of recordings are at a nominal rate, half of these by a crystal, half by an RC oscillator
CRYSTAL, OSCILLATOR = 3e-4, 5e-3  # relative tolerance, 1 sigma
ELAPSED_DENSITY = 0.05  # per factor e, of a first stamp of up to a day, beyond it as its power -1.5
ELAPSED_FLOOR = 2e-4  # of a clock that counts from any moment, up to `LONGEST_S` ago
LONGEST_S = 4.1e9  # 130 years
IMPOSSIBLE = 1e-12
DATE_DENSITY, OTHER_DATE = 1.0, 0.05  # per factor e, of stamps from 2000 to 2050, and of others from 1990 to 2100
RECENT_S = (3.16e8, 1.89e9)  # s since 1990, of 2000 to 2050
SAME_TICK = 1e-3  # relative: readings that are one
CLOCK_TOLERANCE = 0.05  # relative, 1 sigma, of a second clock or a stated rate against a unit's


@dataclass(frozen=True, slots=True, eq=False)
class TimeEvidence:
    """What is known of a time column.

    ``stamps`` (n,) are finite. ``named`` are the units that its name states (`LIE_ODDS`) or hints at, each with
    the odds for it; ``scale_s`` [s] is the header's; ``second_clock_s`` [s] is how long one unit is by another
    clock in the file; ``rate_hz`` [Hz] was stated.
    """

    stamps: FloatArray
    named: Mapping[TimeUnit, float] = field(default_factory=dict)
    scale_s: float | None = None
    second_clock_s: float | None = None
    rate_hz: float | None = None


@dataclass(frozen=True, slots=True)
class TimeReading:
    """One unit's reading: ``log_weight`` its log posterior against all others, the rate [Hz], the duration [s]."""

    unit: TimeUnit
    log_weight: float
    rate_hz: float
    duration_s: float


@dataclass(frozen=True, slots=True)
class TimeDecision:
    """Readings, the most probable first; ``winner`` is None where the evidence leaves more than one."""

    readings: tuple[TimeReading, ...]
    winner: TimeReading | None


def usual_step(stamps: FloatArray) -> tuple[float, float]:
    """Return the mean step from row to row of stamps (n,) and its relative standard uncertainty.

    Gaps and falls are left out; rows that share a stamp count. The step is 0 where the stamps rise less than twice
    and rows share them.
    """
    step = np.diff(stamps)
    rises = np.flatnonzero(step > 0)
    if not len(rises):
        return 0.0, 1.0
    if (step == 0).mean() > 0.01:  # rows that share a stamp: from one rise to another
        if len(rises) < 2:
            return 0.0, 1.0
        step = step[rises[0] + 1 : rises[-1] + 1]
    usual = float(np.median(step[step > 0]))
    kept = step[(step >= 0) & (step <= _longest_step(step, usual))]
    mean = float(kept.mean())
    return mean, float(kept.std() / mean / math.sqrt(len(kept))) + 1e-7


def _longest_step(step: FloatArray, usual: float) -> float:
    """Return the longest step that is no gap: of rounded stamps a step may be one more count than the usual."""
    grain = float(np.min(np.abs(step - usual)[step != usual], initial=np.inf))
    next_count = (step > usual) & (step < usual + 1.1 * grain)
    is_rounded = grain > 0.3 * usual and next_count.mean() > ROUNDED_SHARE
    return max(1.6 * usual, usual + 1.1 * grain if is_rounded else 0.0)


def evidence_rows(stamps: FloatArray) -> int:
    """Return how many of the first ``stamps`` (n,) the decision looks at; more than n where it needs more.

    `EVIDENCE_ROWS`, or as many as hold `EVIDENCE_RISES` steps.
    """
    if int((np.diff(stamps[:EVIDENCE_ROWS]) > 0).sum()) >= EVIDENCE_RISES:
        return EVIDENCE_ROWS
    rises = np.flatnonzero(np.diff(stamps) > 0)
    if len(rises) < EVIDENCE_RISES:
        return len(stamps) + 1
    return max(EVIDENCE_ROWS, int(rises[EVIDENCE_RISES - 1]) + 2)


def may_be_clock(stamps: FloatArray) -> bool:
    """Say whether stamps (n,) may be of a clock, and have not shown it yet: more rows decide."""
    return len(stamps) > 0 and is_clock(stamps) and not minute_jumps(stamps)


def decide(evidence: TimeEvidence) -> TimeDecision:
    """Return the readings of a time column in every unit, and the winner where there is one.

    The posterior of a unit is its prior times the likelihood of each piece of evidence. Units of one length are
    one reading. A unit wins if its odds against the next are `WINNING_ODDS`.
    """
    stamps = evidence.stamps
    head = stamps[: evidence_rows(stamps)]
    step, uncertainty = usual_step(head)
    if step <= 0:
        return TimeDecision((), None)
    is_of_clock = is_clock(head) and is_clock(stamps)
    jumps = minute_jumps(stamps) if is_of_clock else 0
    rising = np.diff(stamps)
    elapsed = float(np.sum(rising, where=rising > 0))  # a counter that wraps goes on
    decimals = printed_decimals(head)
    units = list(dict.fromkeys((*TIME_UNITS, *evidence.named)))
    if evidence.scale_s is not None:
        units.append(TimeUnit(f"tick:{evidence.scale_s:.10g}", evidence.scale_s, 0.5))
    found = list[TimeReading]()
    for unit in units:
        if unit.digits and not is_of_clock:
            continue
        if (first := _first_stamp(unit, head)) == 0:
            continue
        rate, sigma, duration = 1 / (step * unit.seconds), uncertainty, elapsed * unit.seconds
        if unit.digits:
            linear = unit.linear(stamps)
            own_step, sigma = usual_step(linear[: len(head)])
            if own_step <= 0:  # 60 and 100 are the same second
                continue
            midnights = int((np.diff(linear) < -DAY_S / 2).sum())
            rate, duration = 1 / own_step, float(linear[-1] - linear[0]) + midnights * DAY_S
        weight = math.log(max(unit.prior, 1e-3) * first)
        weight += 0.0 if decimals is None else math.log(unit.printed[min((decimals + 2) // 3, 2)])
        weight += math.log(rate_density(rate, sigma)) + _log_agreement(evidence, unit, rate)
        if jumps:
            weight += math.log(LIE_ODDS) if unit.digits else 0.0
        found.append(TimeReading(unit, weight, rate, duration))
    return _decided(_merged(found), evidence)


def printed_decimals(stamps: FloatArray) -> int | None:
    """Return with how many decimals stamps (n,) were printed; None where with more than `MAX_DECIMALS`."""
    largest = float(np.max(np.abs(stamps)))
    for decimals in range(MAX_DECIMALS + 1):
        scaled = stamps * 10.0**decimals
        resolved = 4 * np.finfo(float).eps * largest * 10.0**decimals
        if resolved > 0.1:
            return None
        if bool(np.all(np.abs(scaled - np.round(scaled)) <= resolved)):
            return decimals
    return None


def _first_stamp(unit: TimeUnit, head: FloatArray) -> float:
    """Return the density of the first stamp in a unit, per factor e; 0 where it cannot be."""
    if unit.name == "hhmmss":  # any moment of the day is as likely
        return max(float(unit.linear(head[:1])[0]), 1.0) / DAY_S
    if unit.dates is None:
        start = max(abs(float(head[0])) * unit.seconds, 1.0)
        density = max(ELAPSED_DENSITY * min(1.0, DAY_S / start) ** 1.5, ELAPSED_FLOOR)
        return density if start < LONGEST_S else IMPOSSIBLE
    middle = float(head[len(head) // 2])
    if unit.digits:
        return DATE_DENSITY if unit.dates[0] <= middle <= unit.dates[1] else 0.0
    if not unit.dates[0] <= middle <= unit.dates[1]:
        return 0.0
    return DATE_DENSITY if RECENT_S[0] < (middle - unit.dates[0]) * unit.seconds < RECENT_S[1] else OTHER_DATE


def rate_density(rate_hz: float, uncertainty: float = 0.0) -> float:
    """Return how common a sample rate is, per factor e: nominal ones within their tolerance, and a smooth part."""
    x = math.log(rate_hz)
    smooth = float(np.exp(np.interp(x, np.log(_SMOOTH_HZ), np.log(_SMOOTH), left=-30.0, right=-30.0)))
    off = x - np.log(NOMINAL_HZ)
    shares = np.exp(np.interp(np.log(NOMINAL_HZ), np.log(_SMOOTH_HZ), np.log(_SMOOTH)))
    shares /= shares.sum()
    peaks = 0.0
    for tolerance in (CRYSTAL, OSCILLATOR):
        sigma = math.hypot(tolerance, uncertainty)
        peaks += 0.5 * float(np.sum(shares * np.exp(-0.5 * (off / sigma) ** 2))) / (sigma * math.sqrt(2 * math.pi))
    return NOMINAL_SHARE * peaks + (1 - NOMINAL_SHARE) * smooth


def _log_agreement(evidence: TimeEvidence, unit: TimeUnit, rate_hz: float) -> float:
    """Return the log odds of what states the unit or rate: name, scale in the header, other clock, stated rate."""
    total = 0.0
    alike = [odds for named, odds in evidence.named.items() if _is_same(named, unit)]
    total += math.log(max(alike, default=1.0))
    if evidence.scale_s is not None and _is_near(unit.seconds, evidence.scale_s, SAME_TICK) and not unit.digits:
        total += math.log(LIE_ODDS)
    if evidence.second_clock_s is not None:
        total += _log_clock(math.log(unit.seconds / evidence.second_clock_s))
    if evidence.rate_hz is not None:
        total += _log_clock(math.log(rate_hz / evidence.rate_hz))
    return total


def _log_clock(off: float) -> float:
    return max(-0.5 * (off / CLOCK_TOLERANCE) ** 2, -math.log(LIE_ODDS))


def _is_same(a: TimeUnit, b: TimeUnit) -> bool:
    return a.digits == b.digits and _is_near(a.seconds, b.seconds, SAME_TICK)


def _is_near(a: float, b: float, tolerance: float) -> bool:
    return abs(math.log(a / b)) < tolerance


def _merged(readings: Sequence[TimeReading]) -> list[TimeReading]:
    """Return the readings, of those of one length the most probable, with the weight of all of them."""
    merged = list[TimeReading]()
    for each in sorted(readings, key=lambda each: -each.log_weight):
        same = next((i for i, other in enumerate(merged) if _is_one_reading(other, each)), None)
        if same is None:
            merged.append(each)
        else:
            first = merged[same]
            weight = float(np.logaddexp(first.log_weight, each.log_weight))
            merged[same] = TimeReading(first.unit, weight, first.rate_hz, first.duration_s)
    return sorted(merged, key=lambda each: -each.log_weight)


def _is_one_reading(a: TimeReading, b: TimeReading) -> bool:
    """Say whether two units make the same of the stamps, as seconds and a clock do within a minute."""
    if a.unit.digits != b.unit.digits:
        return _is_near(a.rate_hz, b.rate_hz, SAME_TICK) and abs(a.duration_s - b.duration_s) < 1e-6
    return _is_same(a.unit, b.unit)


def _decided(readings: Sequence[TimeReading], evidence: TimeEvidence) -> TimeDecision:
    """Return the decision; what contradicts the unit that a header states is never the winner."""
    best = readings[0]
    stated = [unit for unit, odds in evidence.named.items() if odds >= LIE_ODDS]
    contradicts = bool(stated) and not any(_is_near(u.seconds, best.unit.seconds, SAME_TICK) for u in stated)
    contradicts |= any(unit.digits for unit in stated) and not is_clock(evidence.stamps)
    if evidence.scale_s is not None:
        contradicts |= not _is_near(best.unit.seconds, evidence.scale_s, SAME_TICK)
    possible = POSSIBLE_HZ[0] <= best.rate_hz <= POSSIBLE_HZ[1]
    is_clear = len(readings) < 2 or best.log_weight - readings[1].log_weight >= math.log(WINNING_ODDS)
    named = {unit.name for unit in stated}  # what a name states is offered at any rate that is possible
    offered = [
        each for each in readings
        if (POSSIBLE_HZ if each.unit.name in named else OFFERED_HZ)[0] <= each.rate_hz <= OFFERED_HZ[1]
        and each.log_weight > math.log(IMPOSSIBLE)
    ] or [best]  # fmt: skip
    return TimeDecision(tuple(offered), best if is_clear and possible and not contradicts else None)
