"""A campaign that goes on until what is wanted is met: what comes next, when a dwell is enough, how far it is.

It looks at what was done, how long, and how much the unit scatters: never at the values that were found
(`procedures.planning.least_time`). White noise is what was known before, times what the accepted dwells show. Of a
unit of which nothing is known the first dwell lasts two minutes and shows it (`station.guide.measured_noise`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.plan_steps import Dwell, Step, Turn
from procedures.planning.campaign_design import TURNS, CampaignDesign, HandTimes, Placement, usual_design
from procedures.planning.design_sigmas import DesignSigmas, wanted, with_all_solved
from procedures.planning.least_time import NextPlacement, is_enough, next_placement
from procedures.planning.step_information import StepInformation, UnitNoise
from procedures.units import S_PER_MIN
from station.files.campaign_folder.plan_file import WantedRecord
from station.guide.accepted_dwell import AcceptedDwell
from station.guide.measured_noise import NOISE_S, measured_noise
from station.guide.view import LimitView
from station.results.planning.continued import NO_ATTITUDE_LEFT, SigmaSoFar, all_else, sigmas_so_far

LEAST_FACTOR, MOST_FACTOR = 0.5, 3.0  # by which white noise may differ from what was known: more is no noise
NUMBERS = {(step.axis, step.direction): i for i, step in enumerate(TURNS)}
MET = "all targets are met"
FIRST_POSITION = 1  # of a unit whose noise is not known
NOT_KNOWN = f"the noise of this unit is unknown: it is measured for {NOISE_S:.0f} s at rest, then the plan is made"


class SequentialCampaign:
    """``bench`` has site, cube and care; ``done`` are the placings of a campaign that is resumed, by step.

    ``counts`` says whether the unit counts: of one whose noise is not known, its dwells show that too. Of a plan
    that is fixed, ``is_fixed``, it only says how far what is limited is.
    """

    def __init__(
        self, bench: Campaign, record: WantedRecord, done: Iterable[tuple[str, Placement]] = (), *,
        counts: bool = True, is_fixed: bool = False,
    ) -> None:  # fmt: skip
        self._bench, self._hands = bench, HandTimes(record.placing_s, record.move_s)
        self._asked, self._counts = wanted(record.sigmas), counts
        self._is_fixed, self._is_measured = is_fixed, record.accel_white is None
        self._known: UnitNoise | None = None  # until the first dwell has shown it
        self._steps: StepInformation | None = None  # by the noise that is reckoned with
        self._take(noise_of(record))
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
        if (placing := _placing(step, seconds, is_carried=is_carried)) is not None:
            self._done.append((step.name, placing))

    def _take(self, noise: UnitNoise | None) -> None:
        """Reckon by a unit's noise, where it is known."""
        if noise is not None:
            self._known = noise
            self._reckon_by(noise)
            usual = None if self._is_fixed else self._sigmas.of(usual_design())
            self._wanted = self._asked if usual is None else with_all_solved(self._asked, usual)

    def _reckon_by(self, noise: UnitNoise) -> None:
        """Reckon on: the bench stays, and what takes long is of it alone."""
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
            self._reckon_by(self._known.times(float(accel), float(gyro)))

    def steps(self, *, goes_on: bool = False) -> Sequence[Dwell]:
        """Return the dwells that bring it on soonest, the next one first; none when all is met.

        ``goes_on``: the best ones then as well, for who wants more.
        """
        if self._known is None:
            return [Dwell(FIRST_POSITION, NOISE_S)]
        asked = (tuple(self._placings), goes_on, self._sigmas)
        if self._next is None or asked != self._next_of:  # a search of seconds
            self._next = next_placement(self._sigmas, self._wanted, self._placings, goes_on=goes_on)
            self._next_of = asked
        left = self._next.way.placements[len(self._done) :]
        return [Dwell(at.position, at.seconds) for at in left]

    def is_enough(self, step: Step, seconds: float, *, is_carried: bool) -> bool:
        """Say whether all is met with a dwell under way, accepted for so long [s]."""
        so_far = self._with(step, seconds, is_carried=is_carried) if self._known is not None else None
        return so_far is not None and is_enough(self._sigmas, self._wanted, so_far)

    @property
    def noise(self) -> UnitNoise | None:
        """The unit's noise as it is reckoned with; None while it is not known."""
        return None if self._known is None else self._sigmas.steps.noise

    @property
    def said(self) -> str:
        """How far it is and how long it will take, in words."""
        if self._known is None:
            return NOT_KNOWN
        found = self._next
        if found is None or found.placing is None:
            return MET if found is None or found.is_reachable else NO_ATTITUDE_LEFT
        far = ", ".join(one.text for one in self._views(CampaignDesign(tuple(self._placings))))
        left = f"about {np.ceil(found.seconds / S_PER_MIN):.0f} min left"
        return f"{far}, {left if found.is_reachable else 'not reachable with the remaining placements'}"

    def limits(self, step: Step | None, seconds: float, *, is_carried: bool) -> tuple[LimitView, ...]:
        """Return how far each sigma is, with a dwell under way that was accepted for so long [s]."""
        if self._known is None:
            return ()
        key = (len(self._done), step, round(seconds), is_carried, self._sigmas)
        if key != self._limits[0]:  # every view asks, many times a second
            design = None if step is None else self._with(step, seconds, is_carried=is_carried)
            self._limits = key, self._views(design or CampaignDesign(tuple(self._placings)))
        return self._limits[1]

    @property
    def _placings(self) -> list[Placement]:
        return [at for _, at in self._done]

    def _with(self, step: Step, seconds: float, *, is_carried: bool) -> CampaignDesign | None:
        placing = _placing(step, seconds, is_carried=is_carried) if seconds else None
        others = [at for name, at in self._done if name != step.name]
        return None if placing is None else CampaignDesign((*others, placing))

    def _views(self, design: CampaignDesign) -> tuple[LimitView, ...]:
        found = self._sigmas.of(design) if design.placements else np.full(len(self._asked.sigma), np.inf)
        shown = tuple(_view(each) for each in sigmas_so_far(found, self._asked))
        worst = float(self._wanted.worst(found))
        return (*shown, _all_else(worst)) if worst > 1 and all(one.share >= 1 for one in shown) else shown

    def _ratios(self, dwell: AcceptedDwell, seconds: float) -> tuple[float, float]:
        """Return by what factor the variances of both triads' rates are above those that were known."""
        assert self._known is not None
        known, T = replace(self._known, wander=0.0), np.array([seconds])
        return (
            _ratio(dwell.accel_std, known.accel_scale, known.accel_variance(T)[0]),
            _ratio(dwell.gyro_std, known.gyro_scale, known.gyro_variance(T)[0]),
        )


def noise_of(record: WantedRecord) -> UnitNoise | None:
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


def _placing(step: Step, seconds: float, *, is_carried: bool) -> Placement | None:
    if isinstance(step, Turn):
        return Placement(step.start_position, 0.0, NUMBERS[step.axis, step.direction], is_carried)
    return Placement(step.position, seconds, None, is_carried) if isinstance(step, Dwell) else None


def _all_else(ratio: float) -> LimitView:
    """Return how far that is which nobody limits: `TIMES_USUAL` sigmas of the usual campaign are enough."""
    return LimitView(text=all_else(ratio), share=1 / ratio**2)


def _view(each: SigmaSoFar) -> LimitView:
    return LimitView(text=each.text, share=min(1 / each.ratio**2, 1.0) if each.ratio > 0 else 1.0)
