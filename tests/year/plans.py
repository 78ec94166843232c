"""What a campaign of the year is asked to record: the usual plan now and then, mostly a short one."""

import numpy as np

from procedures.campaign.plan_steps import Dwell, Step, Turn
from procedures.frames import AXES
from procedures.positions import TURN_START

WHOLE_SHARE = 1 / 8  # of campaigns: the usual plan takes three times the time of a short one
TURNED_SHARE = 1 / 4  # of short plans: about one axis, there and back
REST_S = 5.0  # at each end of a turn


def drawn_plan(rng: np.random.Generator, dwell_s: float) -> list[Step]:
    """Return the steps of a short plan, empty for the usual one.

    Each face once, in one of its two positions, and one to three of the positions that are left: a second heading
    of a face tells its slab's tilt from the unit's misalignment.
    """
    if rng.random() < WHOLE_SHARE:
        return []
    first = [2 * face + int(rng.integers(1, 3)) for face in range(6)]
    others = [position for position in range(1, 13) if position not in first]
    more = rng.choice(others, int(rng.integers(1, 4)), replace=False)
    steps: list[Step] = [Dwell(int(position), dwell_s) for position in sorted([*first, *more])]
    if rng.random() < TURNED_SHARE:
        axis = str(rng.choice(list(AXES)))
        steps += [Turn(axis, direction, 1, TURN_START[axis], REST_S) for direction in "+-"]
    return steps
