"""How far a hand turn came back to where it began, as far as that can be told."""

from dataclasses import replace

import numpy as np

from procedures.gyrocompass import Known, heading_change
from procedures.steps import Turn
from station.guide.desk import Desk
from station.live.stillness import Block
from station.live.turning import TurnWatch

WORTH_DEG = 5.0  # a wider sigma says nothing
OPPOSITE_STD_DEG = 0.002  # noise of two turns and of the rest before them


def came_back(desk: Desk, step: Turn, watch: TurnWatch) -> tuple[float, float] | None:
    """Return how far off the turn ended [deg], counter-clockwise, and 1 sigma; None where nothing tells.

    The turn the other way about the same axis has the same scale factor, so that the difference of both angles
    is closure alone; before there is one, the horizontal Earth rate before and after tells, by its noise.
    """
    opposite = replace(step, direction="-" if step.direction == "+" else "+")
    if (other := desk.turns.get(opposite.name)) is not None:
        off = (watch.counts_per_revolution / other - 1) * 360 * step.revolutions
        return off, OPPOSITE_STD_DEG
    k = desk.rough_gyro_k(watch.rest_rate)
    before, after = watch.rests
    before, after = before[:-1], after[1:]  # the turn may reach into those: slow, but leaking into level gyros
    if not before or not after:
        return None
    angle, std = np.degrees(
        heading_change(_known(desk, step, before), _known(desk, step, after), desk.facts.latitude, desk.C_ib, k)
    )
    return (float(angle), float(std)) if std < WORTH_DEG else None


def in_words(closing: tuple[float, float] | None) -> str:
    """Return it for people."""
    if closing is None:
        return ""
    return f"came back within {abs(closing[0]):.2f} deg (1 sigma {closing[1]:.2f})"


def _known(desk: Desk, step: Turn, blocks: list[Block]) -> Known:
    rate = np.mean([block.rate[:3] for block in blocks], axis=0)
    return Known(step.start_position, rate, desk.gyro_std(len(blocks)))
