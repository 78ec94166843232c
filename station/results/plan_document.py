"""A planned campaign, as `planned/1` and as text: minutes, steps, each sigma with the wanted and the usual.

Of a campaign in progress: its placements as a design has them, and what comes next in words.
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fixtures_db.imu_models import UNITS
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.frames import AXES
from procedures.planning.campaign_design import TURNS, CampaignDesign, Placement, usual_design
from procedures.planning.design_sigmas import IN_PLACE, NAMES, TIMES_USUAL, DesignSigmas, WantedSigmas
from procedures.planning.identifiability import identifiable_effects
from procedures.planning.least_time import NextPlacement, PlannedCampaign
from procedures.planning.step_information import UnitNoise
from procedures.positions import ATTITUDES, face_of
from procedures.units import ARCSEC_PER_RAD, PPM_PER_ONE, S_PER_H, S_PER_MIN, UG_PER_G
from station.files.campaign_folder.campaign_reading import read_campaign
from station.results.parameters_by_name import title_of
from station.text import significant, table_lines

SHOWN = {"g": (UG_PER_G, "ug"), "1": (ARCSEC_PER_RAD, "arcsec")}
DIGITS = 3


@dataclass(frozen=True, slots=True)
class PlannedStep:
    """A dwell in an attitude, which x, y and z point where, or a turn with its name; how long it takes."""

    kind: Literal["dwell", "turn"]
    axes: str | None
    up: str | None
    name: str | None
    seconds: float


@dataclass(frozen=True, slots=True)
class PlannedSigma:
    """A parameter's standard uncertainty: ``wanted``, by the plan and by the usual one; None where there is none.

    Of a scale factor in ppm, else in the unit of files.
    """

    parameter: str
    unit: str
    wanted: float | None
    plan: float | None
    usual: float | None

    @property
    def is_missed(self) -> bool:
        """Whether it is above what is wanted."""
        return self.wanted is not None and (self.plan is None or self.plan > self.wanted)

    @property
    def is_given_up(self) -> bool:
        """Whether nobody asked for it, and the plan leaves it worse than `TIMES_USUAL` usual ones."""
        if self.wanted is not None or self.usual is None or self.parameter.startswith(FOLLOWS_GRAVITY):
            return False
        return self.plan is None or self.plan > TIMES_USUAL * self.usual

    @property
    def cells(self) -> tuple[str, ...]:
        """Name, what is wanted, plan and usual as people read them, and the unit."""
        times, unit = SHOWN.get(self.unit, (1.0, self.unit))
        numbers = (
            "-" if one is None else significant(times * one, DIGITS)
            for one in (self.wanted, self.plan, self.usual)
        )
        return (title_of(self.parameter), *numbers, unit)

    @property
    def missed(self) -> str:
        """What is wanted and not reached."""
        name, wanted, plan, _, unit = self.cells
        return f"not reachable: {name} {wanted} {unit}; best possible {'nothing' if plan == '-' else plan} {unit}"

    @property
    def given_up(self) -> str:
        """What the plan leaves worse than usual."""
        name, _, plan, usual, unit = self.cells
        return f"less accurate in return: {name} {'open' if plan == '-' else plan} {unit}, usually {usual}"


FOLLOWS_GRAVITY = "accelerometer.scale_factor"  # the site's: no plan changes it


@dataclass(frozen=True, slots=True)
class Identified:
    """Whether a diagnosis would detect an error term of plausible size, and which others look like it."""

    is_told: bool
    not_apart: tuple[str, ...]

    def __str__(self) -> str:
        return ", or ".join(["yes", *map(title_of, self.not_apart)]) if self.is_told else "no"


@dataclass(frozen=True, slots=True)
class PlannedDiagnosis:
    """An error term of the instrument, and how far a plan and the usual one identify it; None: not at all."""

    effect: str
    plan: Identified | None
    usual: Identified | None


@dataclass(frozen=True, slots=True)
class Plan:
    """A planned campaign; its fields are the keys of `planned/1`. ``noise`` and ``hands_s`` have their source."""

    format: str
    minutes: float
    usual_minutes: float
    steps: tuple[PlannedStep, ...]
    effects: tuple[PlannedDiagnosis, ...]
    sigmas: tuple[PlannedSigma, ...]
    noise: dict[str, Any]
    hands_s: dict[str, Any]

    @property
    def is_met(self) -> bool:
        """Whether all is met that is wanted."""
        return not any(one.is_missed for one in self.sigmas)


def plan_of(found: PlannedCampaign, asked: WantedSigmas, sigmas: DesignSigmas, stated: dict[str, str]) -> Plan:
    """Return a plan; ``stated`` has where noise and hands' times are from, in words."""
    hands, usual = sigmas.steps.hands, usual_design()
    return Plan(
        format="planned/1",
        minutes=round(found.design.minutes(hands), 2),
        usual_minutes=round(usual.minutes(hands), 2),
        steps=tuple(_step(at, sigmas) for at in found.design.placements),
        effects=_diagnoses(sigmas, found.design),
        sigmas=_sigmas(found.sigmas, asked, sigmas.of(usual)),
        noise=noise_table(sigmas.steps.noise) | {"source": stated["noise"]},
        hands_s=asdict(hands) | {"source": stated["hands"]},
    )


def _sigmas(found: FloatArray, asked: WantedSigmas, usual: FloatArray) -> tuple[PlannedSigma, ...]:
    """Return each parameter that a plan can do something about, of sigmas ``found``, ``usual`` (30,)."""
    rows = []
    for i, name in enumerate(NAMES):
        if not IN_PLACE[i]:
            times, unit = _planned_unit(name)
            values = (asked.sigma[i], found[i], usual[i])
            rows.append(
                PlannedSigma(name, unit, *(float(times * one) if np.isfinite(one) else None for one in values))
            )
    return tuple(rows)


def _planned_unit(name: str) -> tuple[float, str]:
    return (PPM_PER_ONE, "ppm") if ".scale_factor" in name else (1.0, UNITS[name][0])


def _diagnoses(sigmas: DesignSigmas, design: CampaignDesign) -> tuple[PlannedDiagnosis, ...]:
    """Return which effects of the instrument a diagnosis identifies by a design and by the usual one, moves in."""
    plan, usual = (
        {one.name: Identified(one.is_identified, one.not_apart) for one in identifiable_effects(sigmas, each)}
        for each in (design, usual_design())
    )
    return tuple(PlannedDiagnosis(name, plan.get(name), usual.get(name)) for name in plan | usual)


def noise_table(noise: UnitNoise) -> dict[str, Any]:
    """Return a unit's noise by axis: ug/sqrt(Hz), deg/sqrt(h); the bias instability in deg/h."""
    return {
        "accelerometer_g_sqrt_s": dict(zip(AXES, noise.accel_white.tolist(), strict=True)),
        "gyroscope_deg_sqrt_h": dict(zip(AXES, (noise.gyro_white * np.sqrt(S_PER_H)).tolist(), strict=True)),
        "wander_deg_h": noise.instability * S_PER_H,
    }


def _step(at: Placement, sigmas: DesignSigmas) -> PlannedStep:
    if at.turn is not None:
        step = CampaignDesign((at,)).steps()[0]
        return PlannedStep("turn", None, None, step.name, sigmas.steps.hands.turn)
    return PlannedStep("dwell", ATTITUDES[at.position - 1], face_of(at.position), None, at.seconds)


def plan_text(plan: Plan) -> str:
    """Return a summary: minutes, steps, sigmas, what is out of reach."""
    turns = sum(step.kind == "turn" for step in plan.steps)
    steps = [
        (str(number), step.axes or step.name or "", (step.up or "").replace("_", " "), f"{step.seconds:.0f} s")
        for number, step in enumerate(plan.steps, 1)
    ]
    effects = [(title_of(row.effect), str(row.plan or "no"), str(row.usual or "no")) for row in plan.effects]
    lines = [
        f"{plan.minutes:.1f} min: {len(plan.steps) - turns} placements, "
        f"{f'{turns} rotations' if turns else 'no rotations'}; the usual plan takes {plan.usual_minutes:.1f} min",
        *[row.missed for row in plan.sigmas if row.is_missed],
        *[row.given_up for row in plan.sigmas if row.is_given_up],
        "",
        *table_lines(steps, "><<>", ("", "x y z point", "", "for")),
        "",
        *table_lines([row.cells for row in plan.sigmas], "<>>><", ("u of", "target", "plan", "usual", "")),
        "",
        *table_lines(effects, "<<<", ("diagnosis of", "plan", "usual")),
        "",
        f"noise: {plan.noise['source']}",
        f"hands: {plan.hands_s['source']}",
    ]
    return "\n".join(lines)


MOST_DIGITS = 6  # of two numbers that are nearly the same
NO_ATTITUDE_LEFT = "all attitudes are recorded, and the targets cannot be reached: solve with the steps done"
ALL_MET = "all targets are met"


@dataclass(frozen=True, slots=True)
class SigmaSoFar:
    """How far a triad's parameter is by its worst sigma, and the ratio of that sigma to the one that is wanted.

    ``text`` is such as ``gyroscope bias 0.0130 of 0.0200 deg/h``.
    """

    text: str
    ratio: float


def placements_of(folder: Path) -> list[Placement]:
    """Return the dwells and turns of a campaign's folder in the order of their times; raise as `read_campaign`."""
    return [placement for _, placement in placements_in(read_campaign(folder).campaign)]


def placements_in(campaign: Campaign) -> list[tuple[str, Placement]]:
    """Return a campaign's dwells and turns by file, in the order of their times, with whether moves lead there."""
    numbers = {(step.axis, step.direction): i for i, step in enumerate(TURNS)}
    steps = [
        (
            one.turn_on,
            float(one.series.t[0]),
            one.name,
            Placement(one.position, len(one.series) * one.series.period),
        )
        for one in campaign.dwells
    ]
    for turn in campaign.turns:
        placement = Placement(turn.start_position, 0.0, numbers[turn.axis, turn.direction])
        steps.append((turn.turn_on, float(turn.series.t[0]), turn.name, placement))
    steps.sort(key=lambda step: step[:2])
    carried = {(move.before, move.after) for move in campaign.moves}
    before = [""] + [name for _, _, name, _ in steps]
    return [
        (name, replace(placement, is_carried=(before[i], name) in carried))
        for i, (_, _, name, placement) in enumerate(steps)
    ]


def continued_text(found: NextPlacement, asked: WantedSigmas, whole: WantedSigmas) -> str:
    """Return how far each asked sigma is, how long it will take, and the next placement; see `sigmas_so_far`."""
    lines = [one.text for one in sigmas_so_far(found.sigmas, asked, whole)] + [time_left(found)]
    if found.placing is not None:
        axes, up = ATTITUDES[found.placing.position - 1], face_of(found.placing.position).replace("_", " ")
        lines.append(f"next: {axes}, {up}, for {found.placing.seconds:.0f} s")
    return "\n".join(lines)


def time_left(found: NextPlacement) -> str:
    """Return how long a campaign still takes, or why it ends."""
    if found.placing is None:
        return ALL_MET if found.is_reachable else NO_ATTITUDE_LEFT
    if not found.is_reachable:
        return "the targets cannot be reached with the remaining placements"
    return f"about {np.ceil(found.seconds / S_PER_MIN):.0f} min left"


def sigmas_so_far(sigmas: FloatArray, asked: WantedSigmas, whole: WantedSigmas) -> list[SigmaSoFar]:
    """Return every asked triad and kind by its worst axis, of ``sigmas`` (30,).

    ``whole`` is what is asked, and all else as well as it is to be solved: it stands last if it alone is not met.
    """
    ratios, at = asked.ratios(sigmas), dict[str, int]()
    for i, name in enumerate(NAMES):
        if np.isfinite(asked.sigma[i]):
            kind = name.rpartition(".")[0]
            at[kind] = max(at.get(kind, i), i, key=lambda j: float(ratios[j]))
    found = [_so_far(kind, NAMES[i], float(sigmas[i]), float(asked.sigma[i])) for kind, i in at.items()]
    worst = float(whole.worst(sigmas))
    is_rest_alone = worst > 1 and all(one.ratio <= 1 for one in found)
    return [*found, SigmaSoFar(_all_else(worst), worst)] if is_rest_alone else found


def _so_far(kind: str, name: str, now: float, wanted: float) -> SigmaSoFar:
    times, unit = _planned_unit(name)
    times, unit = SHOWN.get(unit, (times, unit))
    if not np.isfinite(now):
        text = f"{title_of(kind)} not yet known, target {significant(times * wanted, DIGITS)} {unit}"
    else:
        text = f"{title_of(kind)} {' of '.join(apart(times * now, times * wanted))} {unit}"
    return SigmaSoFar(text, now / wanted)


def apart(now: float, wanted: float) -> tuple[str, str]:
    """Return both numbers, of any unit, with as many digits as show that the first is larger, where it is."""
    for digits in range(DIGITS, MOST_DIGITS):
        both = significant(now, digits), significant(wanted, digits)
        if now <= wanted or both[0] != both[1]:
            return both
    return significant(now, MOST_DIGITS), significant(wanted, MOST_DIGITS)


def _all_else(ratio: float) -> str:
    """Say how far that is which nobody limits, its worst sigma over `TIMES_USUAL` usual ones."""
    if not np.isfinite(ratio):
        return f"other parameters not yet known, target {TIMES_USUAL:g} times the usual uncertainty"
    return f"other parameters {' of '.join(apart(TIMES_USUAL * ratio, TIMES_USUAL))} times the usual uncertainty"
