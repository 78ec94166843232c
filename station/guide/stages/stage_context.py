"""What all stages share: the stream, the gates, the checklist, and how a step is accepted."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.position_checks import HeadingError, heading_errors
from procedures.bench.seating_check import Closing, TurnCounts, pair_difference, pair_limit
from procedures.campaign.campaign import Fixture
from procedures.campaign.plan_steps import Dwell, Monitor, Soak, Step, Turn
from procedures.counts.count_rate import RateEstimate
from procedures.errors import ErrorCode
from procedures.geodesy import EARTH_RATE
from procedures.gyrocompass import CertainDwell, QuarterHeading, find_heading, rough_scale_factor
from station.errors import DataRefused
from station.guide.campaign.accepted_steps import (
    NO_ACCEPTED_STEPS,
    AcceptedDwell,
    AcceptedSteps,
    accepted_dwell,
    triad_estimates,
)
from station.guide.campaign.checklist import Checklist
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.checks.face_and_stillness import BlockLook, FaceAndStillnessGate
from station.guide.checks.transfers import SWITCHED, TransferChain
from station.guide.checks.turn_closure import TurnClosures, closure_remedy, turns_to_repeat
from station.guide.wording import step_title
from station.stream.live.live_feed import LiveFeed
from station.stream.live.stillness import MIN_VARIANCE, TICKS_PER_BLOCK, series_of_runs
from station.stream.recorder.sample_buffer import SampleRun
from station.stream.stream_events import EventLog

if TYPE_CHECKING:
    from station.guide.campaign.sequential_campaign import SequentialCampaign  # a fixed plan need not wait for it

POWER_CYCLED = "the unit was switched off and on: its biases are solved separately from before"


@dataclass(frozen=True, slots=True, eq=False)
class BenchFacts:
    """What is known of the bench: latitude, 1 sigma of headings and closures [rad], the cube; and the rules.

    ``bias_std`` [g] is the accelerometer bias's 1 sigma wanted, from which a dwell's length follows; None: it is
    given. ``asks``: somebody is there to be asked which way the cube points; else the wanted position is believed
    where the Earth rate does not determine the heading.
    """

    latitude: float
    heading_std: float
    closure_std: float
    fixture: Fixture
    bias_std: float | None = None
    asks: bool = True


class StageContext:
    """Shared by all stages. ``position`` is where the cube is known to stand since it last moved, 0 if not.

    ``targets`` says how far what is limited is, None where nothing is; it is also the ``planner``, which says what
    comes next, in a campaign that goes on until all wanted is met, but None where the plan is fixed.
    """

    def __init__(
        self,
        feed: LiveFeed,
        checklist: Checklist,
        bench: BenchFacts,
        recorder: FolderRecorder,
        done: AcceptedSteps = NO_ACCEPTED_STEPS,
        targets: "SequentialCampaign | None" = None,
    ) -> None:
        self.feed, self.checklist, self.bench, self.recorder = feed, checklist, bench, recorder
        self.targets, self.planner = targets, None if targets is None or targets.is_fixed else targets
        self.C_sb = bench.fixture.C_sb  # (3, 3), from the cube's axes to the IMU's
        self.event_log, self.gate = EventLog(), FaceAndStillnessGate(self.C_sb)
        self.accepted_dwells: dict[str, AcceptedDwell] = {}  # by step
        self.turns: dict[str, TurnCounts] = dict(done.turns)  # those that stand, by step
        steps = {step.name: step for step in checklist.steps if isinstance(step, Turn)}
        standing = [(steps[name].axis, seen) for name, seen in self.turns.items() if name in steps]
        self.closings = TurnClosures(bench.closure_std, standing)
        self.free_attitudes = dict(done.free_attitudes)  # accelerometer count rates (3,), by step
        self.position = 0
        self.look: BlockLook | None = None  # at the last second
        self.seats: dict[int, FloatArray] = {}  # how the cube sat when it was found off, by position
        self.kept_seats: dict[int, FloatArray] = {}  # how it sits where the operator keeps it so, by position
        self.off_seat = 0  # the position in which it was just found off
        self.badly_seated: set[str] = set(done.badly_seated)  # steps recorded with a seat known to be bad
        self.seat_repeats = set[str]()  # steps to be recorded again for their seats, once each
        self.turn_on = done.turn_on  # which one since the campaign began, from 1
        self.earlier_dwells = list(done.earlier)  # those of other turn-ons that sat well, and of which one
        self.turn_rests = dict(done.turn_rests)  # at rest about turns whose seat is not judged yet, by step
        self.chain = TransferChain(is_resumed=any(checklist.attempts.values()))
        self.reported_turned = set[tuple[str, ...]]()  # steps reported with a wrong heading, as recorded now
        self._accel: tuple[tuple[object, ...], list[RateEstimate]] = ((), [])  # by what they are rates of
        self._gyro_k: float | None = None
        self._gyro_k_by: tuple[object, ...] = ()  # the turns and dwells that say it
        for each in done.dwells:
            self._learn(each)
        for step in steps.values():
            if self.closings.undecided(step.axis) == step.direction:
                checklist.redo(step.name)
        if self.targets is not None:
            self.targets.learn(self.accepted_dwells.values(), self.gyro_k)
        self.replan()

    @property
    def well_seated(self) -> list[AcceptedDwell]:
        """The dwells by which a seat can be judged: a seat that is known to be bad would mislead."""
        return [each for name, each in self.accepted_dwells.items() if name not in self.badly_seated]

    @property
    def judges(self) -> list[tuple[AcceptedDwell, int]]:
        """The dwells by which a seat is judged, each with its turn-on, 0 where that is the present one."""
        return [(each, 0) for each in self.well_seated] + self.earlier_dwells

    @property
    def known(self) -> list[CertainDwell]:
        """The gyros' rates where the position is certain."""
        return [CertainDwell(each.position, each.gyro, each.gyro_std) for each in self.accepted_dwells.values()]

    @property
    def gyro_k(self) -> float | None:
        """The gyros' scale factor [count/rad], roughly; None where nothing says it."""
        reported_by = (*self.turns.values(), *self.accepted_dwells.values())
        if reported_by != self._gyro_k_by:  # every view asks, many times a second
            self._gyro_k, self._gyro_k_by = self._found_gyro_k(), reported_by
        return self._gyro_k

    def _found_gyro_k(self) -> float | None:
        if self.turns:
            return float(np.median(self.turn_counts)) / (2 * np.pi)
        found = rough_scale_factor(self.known, self.bench.latitude, self.C_sb)
        return None if found is None or found[1] > 0.3 else found[0]

    def rough_gyro_k(self, rest: FloatArray) -> float:
        """Return the gyros' scale factor [count/rad], else as if ``rest`` (3,) [count/s] were Earth alone."""
        return self.gyro_k or float(np.linalg.norm(rest)) / EARTH_RATE

    @property
    def turn_counts(self) -> list[float]:
        """Counts per revolution of the turns that stand."""
        return [seen.counts for seen in self.turns.values()]

    def accept_turn(self, step: Turn, runs: Sequence[SampleRun], seen: TurnCounts, note: str) -> None:
        """Record a turn; where the turns about its axis do not close, say what is to be done again.

        Raises
        ------
        DataRefused
            If nobody is there to be asked, and more turns would decide nothing. What was recorded stays.
        """
        partner, stated = self.closings.partner(step.axis, step.direction), self.closings.closure_std
        self.turns[step.name] = seen
        found = self.closings.take(step.axis, seen)
        if partner is None or found is Closing.CLOSED:
            self.accept(step, runs, note)
            return
        why = closure_remedy(found, step, pair_difference(seen, partner), pair_limit(seen, partner, stated))
        self.accept(step, runs, note, doubt=why)
        for again in turns_to_repeat(found, step):
            self.checklist.redo(again)
        if not self.bench.asks and self.closings.is_unresolvable(step.axis):
            wide, expected = self.closings.found_std(step.axis), f"closures of {np.degrees(stated):.2g} deg"
            remedy = f"check marks and stop, or state a closure error of {np.degrees(wide):.2g} deg"
            raise DataRefused("hand turns", None, why, expected, remedy, ErrorCode.PROCEDURE)

    def widen_closure(self, axis: str) -> None:
        """State the closure that the turns about an axis show, as the operator's act; they stand as they are."""
        before, now = self.closings.closure_std, self.closings.widen(axis)
        self.recorder.widen_closure(float(np.degrees(before)), float(np.degrees(now)))
        for step in self.checklist.steps:
            if isinstance(step, Turn) and step.axis == axis:
                self.checklist.keep(step.name)
        text = f"closure error is now {np.degrees(now):.2g} deg (u)"
        self.event_log.say("", f"{text}; this is recorded, and uncertainties increase")

    def accept(
        self,
        step: Step,
        runs: Sequence[SampleRun],
        note: str = "",
        kept_seat: FloatArray | None = None,
        doubt: str = "",
        read: Mapping[str, object] = MappingProxyType({}),
        seats: Mapping[Dwell, FloatArray | None] = MappingProxyType({}),
    ) -> None:
        """Record a step; it is reported as accepted once it is on the disk and in the database.

        ``kept_seat`` (2,) [rad]: how far off it sits, where the operator keeps it so. ``doubt``: why it is not to
        stand, which is then reported instead. ``read``: what a monitor read. ``seats``: how far off (2,) [rad] the
        cube sat in dwells before, as this one shows; None: well.
        """
        buffer, period = self.feed.buffer, self.feed.period
        seat = None if kept_seat is None else kept_seat.tolist()
        moved = self.chain.move_to(step, runs[0][0], buffer, period)
        file = self.recorder.accept(
            step, buffer, runs, kept_seat=seat, turn_on=self.turn_on, read=read, moved=moved, seats=seats
        )
        seconds = sum(last - first for first, last in runs) * period
        is_carried = moved is not None and not self.chain.doubt
        no_move = f"no transfer to it: {self.chain.why}" if self.chain.why else self.chain.doubt
        self.recorder.keep_no_move(step, no_move)
        note = ", ".join(filter(None, [note, no_move]))
        self.chain.begin(step, file, runs[-1][1], buffer)
        self.checklist.accept(step, seconds, note)
        if isinstance(step, Dwell):
            self.position = step.position
            self.kept_seats.pop(step.position, None)
            self._forget_earlier(step)
            self.reported_turned = {each for each in self.reported_turned if step.name not in each}
            for each, off in {**seats, step: kept_seat}.items():
                self._mark_seat(each, off)
            found = self.dwell_of(step, runs)
            if not self.accepted_dwells:
                rate = np.concatenate((found.gyro, found.accel))
                self.recorder.keep_first_rest(rate, self.gate.stillness.noise)
            self._learn(found)
        elif isinstance(step, Soak | Monitor):
            self.position = step.position
        if self.targets is not None:
            self.targets.accepted(step, seconds, is_carried=is_carried)
            self.targets.learn(self.accepted_dwells.values(), self.gyro_k)
        if doubt:
            self.event_log.say("rejected", doubt)
            return
        count = sum(n > 0 for n in self.checklist.attempts.values())
        of = "" if self.planner else f" of {len(self.checklist.steps)}"
        parts = [f"accepted: {step_title(step)}", note, f"{count}{of} done"]
        self.event_log.say("accepted", ", ".join(filter(None, parts)))
        self.replan()

    def _mark_seat(self, step: Dwell, off: FloatArray | None) -> None:
        (self.badly_seated.discard if off is None else self.badly_seated.add)(step.name)
        if off is not None:
            self._forget_earlier(step)

    def _forget_earlier(self, step: Dwell) -> None:
        """Judge no seat by the recording of a step at an earlier turn-on any more."""
        self.earlier_dwells = [one for one in self.earlier_dwells if one[0].step.name != step.name]

    def replan(self, *, goes_on: bool = False) -> None:
        """Ask next for what brings a campaign on soonest that goes on until what is wanted is met.

        ``goes_on``: when it is met as well.
        """
        if self.planner is None:
            return
        self.checklist.replan(self.planner.steps(goes_on=goes_on))
        self.recorder.keep_steps(self.checklist.steps)
        self.event_log.say("", self.planner.status_text)

    def is_enough(self, step: Step, seconds: float) -> bool:
        """Say whether a dwell under way, accepted for so long [s], is the last that is needed."""
        return self.planner is not None and self.planner.is_enough(step, seconds, is_carried=self.is_carried)

    @property
    def is_carried(self) -> bool:
        """Whether the move that ended last will be used."""
        return not (self.chain.why or self.chain.doubt)

    def tilts_taken(self) -> list[FloatArray]:
        """Return the unit vectors (3,), cube axes, that were up in each free position done for good."""
        open_steps = {step.name for step in self.checklist.steps if self.checklist.is_open(step)}
        taken = [rate for name, rate in self.free_attitudes.items() if name not in open_steps]
        return [self.gate.way_up(rate) for rate in taken]

    def accel_rates(self, runs: Sequence[SampleRun]) -> list[RateEstimate]:
        """Estimate the accelerometers' rates over accepted samples: seat, creep and record ask for the same."""
        period = self.feed.period
        asked = (*runs, period)
        if asked != self._accel[0]:
            recorded = series_of_runs(self.feed.buffer, runs, period)
            self._accel = asked, triad_estimates(recorded.accel, recorded)
        return self._accel[1]

    def dwell_of(self, step: Dwell, runs: Sequence[SampleRun]) -> AcceptedDwell:
        """Return what a dwell, recorded as the samples of ``runs``, leaves for those after it."""
        recorded = series_of_runs(self.feed.buffer, runs, self.feed.period)
        return accepted_dwell(step, recorded, self.accel_rates(runs))

    def set_dwell(self, seconds: float) -> None:
        """Have every open dwell last ``seconds``."""
        self.checklist.set_dwell(seconds)
        self.recorder.keep_steps(self.checklist.steps)

    def heading(self, gyro: FloatArray, seconds: float, face: str) -> QuarterHeading:
        """Say which way the cube stands with ``face`` up, from the mean count rates ``gyro`` (3,) [count/s]."""
        std, bench = self.gyro_std(seconds), self.bench
        return find_heading(gyro, std, face, bench.latitude, self.C_sb, self.known)

    def power_cycled(self, then: str = "") -> None:
        """Take it that the unit was switched off and on: what its biases were says nothing of what they are.

        ``then`` is what comes next, for the report.
        """
        self.earlier_dwells += [(each, self.turn_on) for each in self.well_seated]
        self.turn_on += 1
        self.accepted_dwells.clear()
        self.turn_rests.clear()
        self.seats.clear()
        self.kept_seats.clear()
        self.chain.broken(SWITCHED)
        self.moved()
        self.event_log.say("rejected", POWER_CYCLED + then)

    def wrong_headings(self) -> list[tuple[list[Dwell], HeadingError]]:
        """Return the dwells whose heading was off the marks, as far as the gyroscopes show it by now."""
        k, known, steps = self.gyro_k, self.known, [each.step for each in self.accepted_dwells.values()]
        if k is None:
            return []
        bench = self.bench
        errors = heading_errors(known, bench.latitude, self.C_sb, k * np.eye(3), bench.heading_std)
        return [([steps[i] for i in error.dwells], error) for error in errors]

    def moved(self) -> None:
        """Take it that the cube no longer stands where it stood."""
        self.position = self.off_seat = 0

    def gyro_std(self, seconds: float) -> FloatArray:
        """Return 1 sigma (3,) of a mean gyro count rate over ``seconds``: noise and the counter's step."""
        noise = np.maximum(self.gate.stillness.noise[:3], MIN_VARIANCE) * TICKS_PER_BLOCK
        std: FloatArray = np.sqrt(noise / seconds + 1 / (6 * seconds**2))
        return std

    def _learn(self, found: AcceptedDwell) -> None:
        self.accepted_dwells[found.step.name] = found
        self.gate.learn_rest(found.gyro)
        self.gate.learn_faces({each.face: each.accel for each in self.accepted_dwells.values()})
