"""How the cube sat as it was turned: judged at rest before and after, and once there are dwells to judge it by."""

import numpy as np

from procedures.bench.seating_check import MIN_TILT_SIGMAS, PositionRates, judge
from procedures.campaign.plan_steps import Turn
from procedures.units import RAD_PER_ARCSEC
from station.guide.accepted_dwell import rates_and_sigmas
from station.guide.instruction_words import step_title
from station.guide.seating_watch import ALIKE_RAD, compared
from station.guide.stage_context import StageContext
from station.stream.live.stillness import Block, runs_of_blocks


def rest_rates(context: StageContext, position: int, blocks: list[Block]) -> PositionRates:
    """Return the accelerometers' rates at rest over ``blocks``, and their sigmas."""
    return position, *rates_and_sigmas(context.accel_rates(runs_of_blocks(blocks, None)))


def lies_otherwise(before: PositionRates, after: PositionRates) -> str:
    """Say by how much the cube lies otherwise after a turn than before it; empty if it does not.

    After whole revolutions slab, face, bias and misalignment are the same as before: only noise may differ.
    """
    up = int(np.argmax(np.abs(before[1])))
    per_g, level = np.abs(before[1][up]), [i for i in range(3) if i != up]
    off = (after[1] - before[1])[level] / per_g
    limit = np.maximum(MIN_TILT_SIGMAS * np.hypot(before[2], after[2])[level] / per_g, ALIKE_RAD)
    if np.all(np.abs(off) <= limit):
        return ""
    return f"the cube is tilted by {np.linalg.norm(off) / RAD_PER_ARCSEC:.0f} arcsec against its earlier seating"


def keep_to_judge(context: StageContext, step: Turn, before: PositionRates, after: PositionRates) -> None:
    """Remember a turn's rests until there are dwells to judge them by."""
    mean = (before[1] + after[1]) / 2
    context.turn_rests[step.name] = before[0], mean, np.hypot(before[2], after[2]) / 2


def reject_tilted_turns(context: StageContext) -> None:
    """Have the turns done again in which the cube lay tilted, as dwells accepted since then show."""
    for name, rest in list(context.turn_rests.items()):
        step, found = context.checklist.step(name), compared(context.bench, context.judges, rest, is_again=False)
        if isinstance(step, Turn) and found is not None and (why := judge(found)) and context.checklist.redo(name):
            del context.turn_rests[name]
            context.event_log.say("rejected", f"{step_title(step)}: the cube was {why}; lift, wipe, rotate again")
