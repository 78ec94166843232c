"""A campaign in progress: its placements as a design has them, and what comes next in words."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fixtures_db.imu_models import UNITS
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.frames import ATTITUDES, face_of
from procedures.planning.campaign_design import TURNS, Placement
from procedures.planning.design_sigmas import NAMES, TIMES_USUAL, WantedSigmas
from procedures.planning.least_time import NextPlacement
from procedures.units import PPM_PER_ONE, S_PER_MIN
from station.files.campaign_folder.campaign_reading import read_campaign
from station.results.parameters_by_name import title_of
from station.results.plan_document import DIGITS, SHOWN
from station.text import significant

MOST_DIGITS = 6  # of two numbers that are nearly the same
NO_ATTITUDE_LEFT = "all attitudes are recorded, and the targets cannot be reached: solve with the steps done"


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
        (each.turn_on, float(each.series.t[0]), each.name, Placement(each.position, _seconds(each)))
        for each in campaign.dwells
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


def _seconds(dwell: DwellRecord) -> float:
    return len(dwell.series) * dwell.series.period


def continued_text(found: NextPlacement, asked: WantedSigmas, whole: WantedSigmas) -> str:
    """Return how far each asked sigma is, how long it will take, and the next placement.

    ``whole`` is what is asked, and all else as well as it is to be solved: said where it alone is not met.
    """
    so_far, worst = sigmas_so_far(found.sigmas, asked), float(whole.worst(found.sigmas))
    lines = [one.text for one in so_far]
    if worst > 1 and all(one.ratio <= 1 for one in so_far):
        lines.append(all_else(worst))
    if not found.is_reachable and found.placing is None:
        return "\n".join([*lines, NO_ATTITUDE_LEFT])
    if not found.is_reachable:
        lines.append("the targets cannot be reached with the remaining placements")
    elif found.placing is not None:
        lines.append(f"about {np.ceil(found.seconds / S_PER_MIN):.0f} min left")
    if found.placing is None:
        return "\n".join([*lines, "all targets are met: stop, or continue"])
    axes, up = ATTITUDES[found.placing.position - 1], face_of(found.placing.position).replace("_", " ")
    return "\n".join([*lines, f"next: {axes}, {up}, for {found.placing.seconds:.0f} s"])


def sigmas_so_far(sigmas: FloatArray, asked: WantedSigmas) -> list[SigmaSoFar]:
    """Return every asked triad and kind by its worst axis, of ``sigmas`` (30,)."""
    ratios, worst = asked.ratios(sigmas), dict[str, int]()
    for i, name in enumerate(NAMES):
        if np.isfinite(asked.sigma[i]):
            kind = name.rpartition(".")[0]
            worst[kind] = max(worst.get(kind, i), i, key=lambda j: float(ratios[j]))
    return [_so_far(kind, NAMES[i], float(sigmas[i]), float(asked.sigma[i])) for kind, i in worst.items()]


def _so_far(kind: str, name: str, now: float, wanted: float) -> SigmaSoFar:
    times, unit = (
        (PPM_PER_ONE, "ppm") if ".scale_factor" in name else SHOWN.get(UNITS[name][0], (1.0, UNITS[name][0]))
    )
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


def all_else(ratio: float) -> str:
    """Say how far that is which nobody limits, its worst sigma over `TIMES_USUAL` usual ones."""
    if not np.isfinite(ratio):
        return f"other parameters not yet known, target {TIMES_USUAL:g} times the usual uncertainty"
    return f"other parameters {' of '.join(apart(TIMES_USUAL * ratio, TIMES_USUAL))} times the usual uncertainty"
