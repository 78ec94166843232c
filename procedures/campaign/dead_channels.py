"""Channels that are constant where that cannot be true: named, and excluded where they are dead.

A healthy channel that counts slowly is constant for a while, too. A constant stretch is dead where the cube was
turned about its axis or moved; where a rate output has noise of several steps of its converter; where other
dwells and their attitudes predict more than `MIN_MISSED_COUNTS` counts; or where it stopped within the step: it
would have changed `MIN_EXPECTED_CHANGES` times, as often as before, and moved by more than `MIN_MISSED_COUNTS`
counts. The triad is left out of such a step; of a soak the channel alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import (
    Campaign,
    DwellRecord,
    RateTable,
    RestRecord,
    SequenceRecord,
    SoakRecord,
    StepRecord,
    TurnRecord,
)
from procedures.campaign.observations import channel
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import AXES, TRIADS
from procedures.geodesy import earth_rate_n
from procedures.positions import face_normal, face_of, nominal_C_lb

MIN_MISSED_COUNTS = 10.0  # counts, beyond six sigmas of what the other rests scatter
MIN_EXPECTED_CHANGES = 30.0  # changes, where none came
# counts^2: a walk stays within one count by exp(-pi^2/2 of it); twice, as eight blocks know it
MIN_WALK_COUNTS2 = 16.0
WALK_BLOCKS = 8
MIN_NOISE_LEVELS = 5  # different values of a rate output from which on its noise is several steps of the converter
MIN_CONSTANT_SAMPLES = 8  # samples, below which an end without a change says nothing
MAX_BRAKED_SHARE = 0.2  # of the highest rate of a turn: more than a hand takes away between two samples
MIN_TURN_LEVELS = 20  # different values in a turn, of an output that shows how it is braked
MOVING_RATE_SHARE = 0.02  # of the highest rate of a turn: less is rest
SEQUENCE_WINDOWS = 5  # of what came before in a sequence
MOVING_SPAN_SHARE = 0.5  # of what another channel moves in all of a sequence, to say that it goes on to move


@dataclass(frozen=True, slots=True)
class ConstantEnd:
    """One value from a sample on to the end of a step: ``begin`` 0 is all of it."""

    begin: int
    value: float


def constant_end(values: FloatArray) -> ConstantEnd | None:
    """Return the stretch without a change at the end; None if it is shorter than `MIN_CONSTANT_SAMPLES`.

    ``values`` (n,) are a channel's samples [count, or the unit of a rate output].
    """
    changes = np.flatnonzero(np.diff(values) != 0)
    begin = int(changes[-1]) + 1 if len(changes) else 0
    return ConstantEnd(begin, float(values[-1])) if len(values) - begin >= MIN_CONSTANT_SAMPLES else None


def stopped(values: FloatArray, found: ConstantEnd, counts: bool) -> bool:
    """Say whether a channel at rest, ``values`` (n,), stopped: what it did before cannot have gone on so."""
    before = values[: found.begin]
    tail = len(values) - found.begin
    if found.begin < MIN_CONSTANT_SAMPLES:
        return False
    often = np.count_nonzero(np.diff(before)) / (len(before) - 1)
    if often * tail < MIN_EXPECTED_CHANGES:
        return False
    if counts:
        drift = abs(before.mean() - found.value) * tail > MIN_MISSED_COUNTS + 6 * np.sqrt(before.var() * tail)
        return bool(drift or walk(before) * tail > MIN_WALK_COUNTS2)
    is_outside = found.value < before.min() or found.value > before.max()
    return is_outside or len(np.unique(before)) >= MIN_NOISE_LEVELS


def walk(before: FloatArray) -> float:
    """Return by how many counts^2 a sample the sum of ``before`` (n,) walks, flicker at an edge left out."""
    length = max(len(before) // WALK_BLOCKS, 1)  # the same of all: sums of other lengths differ by their mean
    sums = before[: len(before) // length * length].reshape(-1, length).sum(axis=1)
    return max(float(sums.var(ddof=1)) - 1.0, 0.0) / length


def stopped_in_turn(turn: TurnRecord, values: FloatArray, end: ConstantEnd, is_along: bool) -> bool:
    """Say whether a channel, ``values`` (n,), stopped in a turn; if its rest is constant too, by the way."""
    samples = np.asarray(turn.series.gyro if turn.series.gyro is not None else turn.series.accel)
    off = np.abs(samples - samples[:MIN_CONSTANT_SAMPLES].mean(axis=0))
    moving = np.flatnonzero(np.any(off > MOVING_RATE_SHARE * off.max(initial=0.0), axis=1))
    still = min(int(moving[0]) if len(moving) else len(values), end.begin)
    rest = values[: still // 2]  # a hand begins slowly
    both = np.concatenate((rest, values[end.begin :]))
    if stopped(both, ConstantEnd(len(rest), end.value), isinstance(turn.series, CountSeries)):
        return True
    if not is_along or len(np.unique(values)) < MIN_TURN_LEVELS:
        return False
    begin = float(np.mean(values[:MIN_CONSTANT_SAMPLES]))
    jump = max(abs(values[end.begin - 1] - end.value), abs(end.value - begin))
    return bool(jump > MAX_BRAKED_SHARE * np.max(np.abs(values - begin)))


def stopped_in_sequence(record: SequenceRecord, values: FloatArray, end: ConstantEnd) -> bool:
    """Say whether a channel, ``values`` (n,), stopped while the others of the unit went on to move."""
    parts = [
        part for part in np.array_split(values[: end.begin], SEQUENCE_WINDOWS) if len(part) > MIN_CONSTANT_SAMPLES
    ]
    if len(parts) < SEQUENCE_WINDOWS:
        return False
    often = min(np.count_nonzero(np.diff(part)) / (len(part) - 1) for part in parts)
    triads = [v for v in (record.series.gyro, record.series.accel) if v is not None]
    others = [np.asarray(v, dtype=np.float64) for v in triads]
    spans = [(np.ptp(each[end.begin :], axis=0), np.ptp(each, axis=0)) for each in others]
    moved = any(np.count_nonzero((whole > 0) & (late > MOVING_SPAN_SHARE * whole)) for late, whole in spans)
    return bool(moved and often * (len(values) - end.begin) >= MIN_EXPECTED_CHANGES)


MIN_OWN_AXIS_SHARE = 0.5  # of a turn's axis along the sensor, or of an attitude beyond those of the other dwells
MIN_OTHER_DWELLS = 5  # other dwells that predict one
POSITION_ERROR_RAD = 0.02  # rad by which a position may be off and its channels are still right

R = TypeVar("R", DwellRecord, RestRecord, TurnRecord, SequenceRecord)


@dataclass(frozen=True, slots=True, eq=False)
class _Channel:
    """One channel in all steps of a campaign: its samples by step, and where each ends constant."""

    campaign: Campaign
    triad: str
    axis: int
    steps: Sequence[StepRecord]
    values: Sequence[FloatArray]
    ends: Sequence[ConstantEnd | None]

    @property
    def name(self) -> str:
        return f"{self.triad} {AXES[self.axis]}"

    def is_constant(self, i: int) -> bool:
        end = self.ends[i]
        return end is not None and end.begin == 0

    def dead(self) -> list[int]:
        certain = [i for i in range(len(self.steps)) if self._is_dead(i)]
        order = sorted(range(len(self.steps)), key=lambda i: float(self.steps[i].series.t[0]))
        found, run = set(certain), list[int]()
        for i in [*order, None]:  # a constant step next to a dead one, without a live one between, is dead too
            if i is not None and (self.is_constant(i) or i in found):
                run.append(i)
                continue
            if any(j in found for j in run):
                found |= set(run)
            run = []
        return sorted(found)

    def _is_dead(self, i: int) -> bool:
        step, end = self.steps[i], self.ends[i]
        if end is None:
            return False
        counts = isinstance(step.series, CountSeries)
        if end.begin and isinstance(step, TurnRecord):
            along = self._along(step) if self.triad == "gyroscope" else 0.0
            return stopped_in_turn(step, self.values[i], end, abs(along) > MIN_OWN_AXIS_SHARE)
        if end.begin and isinstance(step, SequenceRecord):
            return stopped_in_sequence(step, self.values[i], end)
        if end.begin:
            return stopped(self.values[i], end, counts)
        if isinstance(step, TurnRecord):
            if self.triad == "gyroscope":
                return bool(abs(self._along(step)) > MIN_OWN_AXIS_SHARE or self._should_swing(len(self.values[i])))
        if isinstance(step, SequenceRecord):
            return True
        if not counts and self._levels() >= MIN_NOISE_LEVELS:
            return True
        return self._is_off(i, end.value) if isinstance(step, DwellRecord) else False

    def _along(self, turn: TurnRecord) -> float:
        return float(self.campaign.fixture.C_sb[self.axis] @ face_normal(face_of(turn.start_position)))

    def _levels(self) -> int:
        """Return how many values its noise takes in the quietest rest that is not constant."""
        rests = [i for i, step in enumerate(self.steps) if isinstance(step, DwellRecord | RestRecord)]
        return min((len(np.unique(self.values[i])) for i in rests if not self.is_constant(i)), default=0)

    def _is_off(self, i: int, value: float) -> bool:
        """Say whether a dwell's constant is not what the other dwells make of its attitude."""
        others = self._other_dwells(value)
        if not others and self.triad == "accelerometer":
            return self._was_up_and_down()
        if len(others) < MIN_OTHER_DWELLS:
            return False
        A, own = np.array([self._input(j) for j in others]), self._input(i)
        mean = np.array([self.values[j].mean() for j in others])
        x, _, rank, _ = np.linalg.lstsq(A, mean, rcond=0.1)
        like_them, *_ = np.linalg.lstsq(A.T, own, rcond=0.1)
        if np.linalg.norm(A.T @ like_them - own) > MIN_OWN_AXIS_SHARE:
            return False  # none of them says what it should put out in this attitude
        scatter = float(np.sqrt(np.sum((mean - A @ x) ** 2) / max(len(mean) - rank, 1)))
        stood = POSITION_ERROR_RAD * float(np.linalg.norm(x[:3]))
        return abs(float(own @ x) - value) > MIN_MISSED_COUNTS / len(self.values[i]) + 6 * scatter + stood

    def _other_dwells(self, value: float) -> list[int]:
        """Return the dwells that put out something else than one constant ``value``, and did not stop."""
        dwells = [j for j, step in enumerate(self.steps) if isinstance(step, DwellRecord)]
        moved = [j for j in dwells if not self.is_constant(j) or self.values[j][-1] != value]
        return [j for j in moved if self.is_constant(j) or not self._is_dead(j)]

    def _should_swing(self, samples: int) -> bool:
        """Say whether a turn's headings should show, by the Earth's rate that spreads the dwells."""
        means = [v.mean() for s, v in zip(self.steps, self.values, strict=True) if isinstance(s, DwellRecord)]
        swing = float(np.ptp(means)) / 2 * np.cos(self.campaign.site.latitude) if means else 0.0
        return bool(swing * samples / 4 > MIN_MISSED_COUNTS)

    def _was_up_and_down(self) -> bool:
        faces = {face_of(s.position) for s in self.steps if isinstance(s, DwellRecord)}
        axis = AXES[int(np.argmax(np.abs(self.campaign.fixture.C_sb[self.axis])))]
        return {f"{axis}_up", f"{axis}_down"} <= faces

    def _input(self, i: int) -> FloatArray:
        step = self.steps[i]
        assert isinstance(step, DwellRecord)
        C = nominal_C_lb(step.position).T
        seen = C[:, 2]
        if self.triad == "gyroscope":
            omega = earth_rate_n(self.campaign.site.latitude)
            seen = C @ omega / np.linalg.norm(omega)
        return np.append(seen, 1.0)


def without_dead(campaigns: Sequence[Campaign]) -> tuple[tuple[Campaign, ...], tuple[str, ...]]:
    """Return the campaigns without the triads of dead channels where these are dead, and warnings of it."""
    kept, wording = list[Campaign](), list[str]()
    for campaign in campaigns:
        for triad in TRIADS:
            dead = [(each, numbers) for each in _channels(campaign, triad) if (numbers := each.dead())]
            wording += [_sentence(each, numbers) for each, numbers in dead]
            gone = {id(each.steps[i]) for each, numbers in dead for i in numbers}
            if gone:
                campaign = _without(campaign, triad, gone)
        tables, in_tables = _tables(campaign)
        kept.append(replace(campaign, rate_tables=tables) if in_tables else campaign)
        wording += in_tables
        in_soaks = [text for soak in campaign.soaks for text in _of_soak(soak)]
        everywhere = [text.split(" in every step")[0] for text in wording if " in every step" in text]
        wording += [text for text in in_soaks if not any(text.startswith(f"{each} in all") for each in everywhere)]
    return tuple(kept), tuple(wording)


def dead_in_soak(soak: SoakRecord, triad: str) -> list[ConstantEnd | None]:
    """Return for each channel (3,) of a soak where it is constant to the end, or stopped; None if alive."""
    samples = channel(soak.series, triad)
    if samples is None:
        return [None] * 3
    counts = isinstance(soak.series, CountSeries)
    found = list[ConstantEnd | None]()
    for values in np.asarray(samples, dtype=np.float64).T:
        end = constant_end(values)
        is_dead = end is not None and (end.begin == 0 or stopped(values, end, counts))
        found.append(end if is_dead else None)
    return found


def _channels(campaign: Campaign, triad: str) -> list[_Channel]:
    steps = [step for step in campaign.steps if channel(step.series, triad) is not None]
    samples = [np.asarray(channel(step.series, triad), dtype=np.float64) for step in steps]
    found = list[_Channel]()
    for axis in range(3):
        values = [each[:, axis] for each in samples]
        found.append(_Channel(campaign, triad, axis, steps, values, [constant_end(v) for v in values]))
    return found


def _sentence(one: _Channel, dead: Sequence[int]) -> str:
    ends = [end for i in dead if (end := one.ends[i]) is not None]
    value = f"{ends[0].value + 0.0:.6g}"
    triad = f"{one.triad}s"
    if len(dead) == len(one.steps) and all(end.begin == 0 for end in ends):
        return f"{one.name} outputs a constant {value} in every step: the {triad} are not used"
    names = [_where(one.steps[i], one.ends[i]) for i in dead]
    text = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    return f"{one.name} outputs a constant {value} in {text}: the {triad} are not used there"


def _where(step: StepRecord | SoakRecord, end: ConstantEnd | None) -> str:
    if end is None or end.begin == 0:
        return f"all of {step.name}"
    return f"{step.name} from {float(step.series.t[end.begin]):.6g} s on"


def _of_soak(soak: SoakRecord) -> list[str]:
    return [
        f"{triad} {axis} outputs a constant {end.value + 0.0:.6g} in {_where(soak, end)}: not used"
        for triad in TRIADS
        for axis, end in zip(AXES, dead_in_soak(soak, triad), strict=True)
        if end is not None
    ]


def _tables(campaign: Campaign) -> tuple[tuple[RateTable, ...], list[str]]:
    """Return the rate tables without the gyroscopes that put out a constant while turned about their own axis."""
    kept, text = list[RateTable](), list[str]()
    for table in campaign.rate_tables:
        along = np.abs(campaign.fixture.C_sb[:, AXES.index(table.axis)]) > MIN_OWN_AXIS_SHARE
        output = np.array(table.output)
        for axis in np.flatnonzero(along & (np.ptp(np.abs(table.reference)) > 0)):
            read = output[np.isfinite(output[:, axis]), axis]
            if len(read) >= MIN_CONSTANT_SAMPLES and np.ptp(read) == 0:
                name, value = f"gyroscope {AXES[axis]}", f"{read[0]:.6g}"
                text.append(f"{name} outputs a constant {value} in all of {table.name}: not used")
                output[:, axis] = np.nan
        kept.append(replace(table, output=output))
    return tuple(kept), text


def _bare(series: Series, triad: str) -> Series:
    return replace(series, gyro=None) if triad == "gyroscope" else replace(series, accel=None)


def _without(campaign: Campaign, triad: str, gone: set[int]) -> Campaign:
    """Return a campaign whose steps (by identity) lack a triad; one that lacks both is no step any more."""

    def kept(records: tuple[R, ...]) -> tuple[R, ...]:
        found = [replace(r, series=_bare(r.series, triad)) if id(r) in gone else r for r in records]
        return tuple(r for r in found if r.series.gyro is not None or r.series.accel is not None)

    return replace(
        campaign, dwells=kept(campaign.dwells), turns=kept(campaign.turns), rests=kept(campaign.rests),
        sequences=kept(campaign.sequences),
    )  # fmt: skip
