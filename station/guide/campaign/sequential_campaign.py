"""A campaign that continues until target uncertainties are met: the next step, when a dwell is enough, progress.

The plan depends on the steps that were done, their length and the unit's noise, never on the estimated values
(`procedures.planning.least_time`). If nothing is known of a unit, its first dwell lasts two minutes and shows the
white noise. Bias instability is not visible at rest: it is assumed to be as much as two minutes of white noise.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fixtures_db.database import Database
from procedures.arrays import FloatArray
from procedures.bench.dwell_length import WHITE_NOISE_FACTOR
from procedures.campaign.campaign import Campaign, Fixture
from procedures.campaign.plan_steps import USUAL_ORDER, Dwell, Step, Turn
from procedures.geodesy import EARTH_RATE
from procedures.planning.campaign_design import TURNS, CampaignDesign, HandTimes, Placement, usual_design
from procedures.planning.design_sigmas import NAMES, DesignSigmas, WantedSigmas, wanted, with_all_solved
from procedures.planning.least_time import NextPlacement, is_enough, next_placement
from procedures.planning.step_information import StepInformation, UnitNoise
from procedures.units import RAD_PER_DEG
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.files.campaign_folder.plan_file import NAMES as NOTES
from station.files.campaign_folder.plan_file import WantedRecord, read_note
from station.guide.campaign.accepted_steps import NO_ACCEPTED_STEPS, AcceptedDwell, AcceptedSteps
from station.guide.campaign.campaign_tables import bench_of
from station.guide.options import TargetUncertainties
from station.guide.view import LimitView
from station.results.plan_document import ALL_MET, SigmaSoFar, sigmas_so_far, time_left
from station.results.plan_inputs import (
    hand_times,
    last_values,
    limits_named,
    noise_in_database,
    noise_of,
    wanted_by,
    wanted_by_name,
)
from station.stream.connected_unit import Unit

NOISE_S = 120.0  # s at rest that show a unit's noise


def measured_noise(
    dwells: Sequence[tuple[AcceptedDwell, float]], gyro_k: float | None, *, counts: bool
) -> UnitNoise:
    """Return the noise that dwells show, each with its seconds; at least one.

    ``gyro_k`` [count/rad]: the gyroscopes' scale factor, else the rate at rest is taken for the Earth's alone; 1 g
    is what the vertical accelerometer counts. ``counts`` says whether the unit counts.
    """
    one_g = max(float(np.max(np.abs(dwell.accel))) for dwell, _ in dwells)
    rest = float(np.linalg.norm(dwells[0][0].gyro))
    per_deg = (gyro_k or rest / EARTH_RATE) * RAD_PER_DEG
    accel, gyro = (
        np.sqrt(np.mean([getattr(dwell, name) ** 2 * seconds for dwell, seconds in dwells], axis=0))
        / WHITE_NOISE_FACTOR
        for name in ("accel_std", "gyro_std")
    )
    scales = (one_g, per_deg) if counts else (np.inf, np.inf)
    instability = float(np.sqrt(np.mean((gyro / per_deg) ** 2) / NOISE_S))
    return UnitNoise(accel / one_g, gyro / per_deg, np.full(3, scales[0]), np.full(3, scales[1]), instability)


LEAST_FACTOR, MOST_FACTOR = 0.5, 3.0  # by which white noise may differ from what was known: more is no noise
NUMBERS = {(step.axis, step.direction): i for i, step in enumerate(TURNS)}
FIRST_POSITION = USUAL_ORDER[0]  # of a unit whose noise is not known
NOT_KNOWN = f"the noise of this unit is unknown: it is measured for {NOISE_S:.0f} s at rest, then the plan is made"


class SequentialCampaign:
    """``bench`` has site, cube and care; ``done`` are the placements of a campaign that is resumed, by step.

    ``counts`` says whether the unit counts: of one whose noise is not known, its dwells show that too. Of a plan
    that is fixed, ``is_fixed``, it only says how far what is limited is.
    """

    def __init__(
        self, bench: Campaign, record: WantedRecord, done: Iterable[tuple[str, Placement]] = (), *,
        counts: bool = True, is_fixed: bool = False,
    ) -> None:  # fmt: skip
        self._bench, self._hands = bench, HandTimes(record.placing_s, record.move_s)
        self._asked, self._counts = wanted(record.sigmas), counts
        self.is_fixed, self._is_measured = is_fixed, record.accel_white is None
        self._known: UnitNoise | None = None  # until the first dwell has shown it
        self._steps: StepInformation | None = None  # computed with the known noise
        self._take(recorded_noise(record))
        self._done = list(done)
        self._next: NextPlacement | None = None
        self._next_of: object = None  # what it was asked for
        self._limits: tuple[object, tuple[LimitView, ...]] = (None, ())  # of which dwell they are

    def accepted(self, step: Step, seconds: float, *, is_carried: bool) -> None:
        """Take it that a step was recorded; what it was recorded as before no longer counts."""
        at = next((i for i, (name, _) in enumerate(self._done) if name == step.name), None)
        if at is not None:
            del self._done[at]
            if at < len(self._done):  # the move to the one after came from what is superseded
                name, after = self._done[at]
                self._done[at] = name, replace(after, is_carried=False)
        if (placement := _placement(step, seconds, is_carried=is_carried)) is not None:
            self._done.append((step.name, placement))

    def _take(self, noise: UnitNoise | None) -> None:
        """Plan with a unit's noise, where it is known."""
        if noise is not None:
            self._known = noise
            self._plan_with(noise)
            usual = None if self.is_fixed else self._sigmas.of(usual_design())
            self._wanted = self._asked if usual is None else with_all_solved(self._asked, usual)

    def _plan_with(self, noise: UnitNoise) -> None:
        """Take another noise; what depends on the bench alone is kept, because it takes long to compute."""
        known = self._steps
        steps = StepInformation(self._bench, noise, self._hands) if known is None else known.with_noise(noise)
        self._steps, self._sigmas = steps, DesignSigmas(steps)

    def learn(self, dwells: Iterable[AcceptedDwell], gyro_k: float | None = None) -> None:
        """Take the white noise as dwells show it; ``gyro_k`` [count/rad] is the gyroscopes' scale, if known."""
        at = {name: at.seconds for name, at in self._done}
        seen = [(each, at[each.step.name]) for each in dwells if each.step.name in at]
        if self._is_measured and seen:
            self._take(measured_noise(seen, gyro_k, counts=self._counts))
            return
        ratios = np.array([self._ratios(each, seconds) for each, seconds in seen])
        if len(ratios) and self._known is not None:
            accel, gyro = np.clip(np.sqrt(np.mean(ratios, axis=0)), LEAST_FACTOR, MOST_FACTOR)
            self._plan_with(self._known.times(float(accel), float(gyro)))

    def steps(self, *, goes_on: bool = False) -> Sequence[Dwell]:
        """Return the dwells that bring it on soonest, the next one first; none when all is met.

        ``goes_on``: the best ones then as well, for who wants more.
        """
        if self._known is None:
            return [Dwell(FIRST_POSITION, NOISE_S)]
        asked = (tuple(self._placements), goes_on, self._sigmas)
        if self._next is None or asked != self._next_of:  # a search of seconds
            self._next = next_placement(self._sigmas, self._wanted, self._placements, goes_on=goes_on)
            self._next_of = asked
        left = self._next.way.placements[len(self._done) :]
        return [Dwell(at.position, at.seconds) for at in left]

    def is_enough(self, step: Step, seconds: float, *, is_carried: bool) -> bool:
        """Say whether all is met with a dwell under way, accepted for so long [s]."""
        so_far = self._with(step, seconds, is_carried=is_carried) if self._known is not None else None
        return so_far is not None and is_enough(self._sigmas, self._wanted, so_far)

    @property
    def noise(self) -> UnitNoise | None:
        """The unit's noise as it is used for planning; None while it is not known."""
        return None if self._known is None else self._sigmas.steps.noise

    @property
    def status_text(self) -> str:
        """How far it is and how long it will take, in words."""
        if self._known is None:
            return NOT_KNOWN
        found = self._next
        if found is None or found.placing is None:
            return ALL_MET if found is None else time_left(found)
        far = ", ".join(one.text for one in self._views(CampaignDesign(tuple(self._placements))))
        return f"{far}, {time_left(found)}"

    def limits(self, step: Step | None, seconds: float, *, is_carried: bool) -> tuple[LimitView, ...]:
        """Return how far each sigma is, with a dwell under way that was accepted for so long [s]."""
        if self._known is None:
            return ()
        key = (len(self._done), step, round(seconds), is_carried, self._sigmas)
        if key != self._limits[0]:  # every view asks, many times a second
            design = None if step is None else self._with(step, seconds, is_carried=is_carried)
            self._limits = key, self._views(design or CampaignDesign(tuple(self._placements)))
        return self._limits[1]

    @property
    def _placements(self) -> list[Placement]:
        return [at for _, at in self._done]

    def _with(self, step: Step, seconds: float, *, is_carried: bool) -> CampaignDesign | None:
        placement = _placement(step, seconds, is_carried=is_carried) if seconds else None
        others = [at for name, at in self._done if name != step.name]
        return None if placement is None else CampaignDesign((*others, placement))

    def _views(self, design: CampaignDesign) -> tuple[LimitView, ...]:
        found = self._sigmas.of(design) if design.placements else np.full(len(self._asked.sigma), np.inf)
        return tuple(_view(each) for each in sigmas_so_far(found, self._asked, self._wanted))

    def _ratios(self, dwell: AcceptedDwell, seconds: float) -> tuple[float, float]:
        """Return by what factor the variances of both triads' rates are above those that were known."""
        assert self._known is not None
        known, T = replace(self._known, instability=0.0), np.array([seconds])
        return (
            _ratio(dwell.accel_std, known.accel_scale, known.accel_variance(T)[0]),
            _ratio(dwell.gyro_std, known.gyro_scale, known.gyro_variance(T)[0]),
        )


def recorded_noise(record: WantedRecord) -> UnitNoise | None:
    """Return a unit's noise as a campaign's folder keeps it; None where its first dwell is to show it."""
    if record.accel_white is None or record.gyro_white is None:
        return None
    never = np.full(3, np.inf)
    return UnitNoise(
        np.array(record.accel_white), np.array(record.gyro_white),
        never if record.accel_scale is None else np.array(record.accel_scale),
        never if record.gyro_scale is None else np.array(record.gyro_scale),
        record.wander,
    )  # fmt: skip


def _ratio(std: FloatArray, scale: FloatArray, variance: FloatArray) -> float:
    """Return the mean of variances over those known; 1 where outputs are no counts, whose unit is another."""
    return float(np.mean((std / scale) ** 2 / variance)) if np.all(np.isfinite(scale)) else 1.0


def _placement(step: Step, seconds: float, *, is_carried: bool) -> Placement | None:
    if isinstance(step, Turn):
        return Placement(step.start_position, 0.0, NUMBERS[step.axis, step.direction], is_carried)
    return Placement(step.position, seconds, None, is_carried) if isinstance(step, Dwell) else None


def _view(each: SigmaSoFar) -> LimitView:
    return LimitView(text=each.text, share=min(1 / each.ratio**2, 1.0) if each.ratio > 0 else 1.0)


def target_record(database: Database, unit: Unit, asked: TargetUncertainties) -> tuple[WantedRecord, list[str]]:
    """Return what is asked of a unit's campaign, and what no campaign can do about some of it.

    Raises
    ------
    DataRefused
        If nothing is known of the limits, or they ask for nothing.
    """
    by_limits, remarks = _wanted_by_limits(database, unit, unit.model if asked.limits else None)
    named = _finite(wanted_by_name(asked.sigma).and_also(by_limits))
    if not named:
        found = f"limits of {unit.model} that define no standard uncertainty"
        remedy = "state the standard uncertainty that you want: --sigma NAME=VALUE"
        raise DataRefused("limits", None, found, "limits with a lower and an upper end", remedy)
    known = noise_of(asked.noise) if asked.noise else noise_in_database(database, unit.model, unit.serial)
    hands, _ = hand_times(database)
    record = WantedRecord(sigmas=named, placing_s=hands.placing, move_s=hands.move)
    if known is None:
        return record, remarks
    noise = known.noise
    return record.model_copy(
        update={
            "accel_white": tuple(noise.accel_white.tolist()), "gyro_white": tuple(noise.gyro_white.tolist()),
            "accel_scale": _counted(noise.accel_scale), "gyro_scale": _counted(noise.gyro_scale),
            "wander": noise.instability,
        }
    ), remarks  # fmt: skip


def targets_of(
    folder: Path, database: Database, unit: Unit, tables: CampaignTable, fixture: Fixture,
    done: AcceptedSteps = NO_ACCEPTED_STEPS,
) -> SequentialCampaign | None:  # fmt: skip
    """Return what says how a folder's campaign goes on; of a fixed plan how far what the unit's model limits is.

    None where a plan is fixed and nothing is limited. Of a fixed plan the noise is that of the campaign's own
    dwells: no older campaign is searched.

    Raises
    ------
    DataRefused
        If the folder's note of what is wanted cannot be read.
    """
    record = read_note(folder, WantedRecord)
    if is_fixed := record is None:
        record = _limits_record(database, unit)
    if record is None or tables.site is None:
        return None
    if unknown := sorted(record.sigmas.keys() - set(NAMES)):
        raise DataRefused(
            folder / NOTES[WantedRecord], None, f"a sigma of {unknown[0]}", "parameters of a solution"
        )
    bench, counts = bench_of(tables.site, tables.procedure, fixture), tables.imu.output != "rate"
    return SequentialCampaign(bench, record, done.placements, counts=counts, is_fixed=is_fixed)


def _limits_record(database: Database, unit: Unit) -> WantedRecord | None:
    """Return what the limits of a unit's model ask for; None where there are none."""
    try:
        named = _finite(_wanted_by_limits(database, unit, unit.model)[0])
    except DataRefused:
        return None
    hands = HandTimes()
    return WantedRecord(sigmas=named, placing_s=hands.placing, move_s=hands.move) if named else None


def _wanted_by_limits(database: Database, unit: Unit, model: str | None) -> tuple[WantedSigmas, list[str]]:
    """Return the sigmas that a model's limits ask for, and what no campaign can do about some of them."""
    _, rows = limits_named(database, model)
    return wanted_by(rows, last_values(database, unit.model, unit.serial))


def _finite(asked: WantedSigmas) -> dict[str, float]:
    return {name: float(one) for name, one in zip(NAMES, asked.sigma, strict=True) if np.isfinite(one)}


def _counted(scale: FloatArray) -> tuple[float, ...] | None:
    return tuple(scale.tolist()) if np.all(np.isfinite(scale)) else None
