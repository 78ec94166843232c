"""What is left out in turn: every position of a campaign, every turn and rest, and everything that was stated.

A position is left out with all its repeats. What a campaign states, each face's certificate, gravity, headings and
closures, is foretold by the rest like a measurement.
"""

import numpy as np

from procedures.arrays import IntArray
from procedures.diagnosis.residual_rows import Evidence


def groups(evidence: Evidence) -> list[IntArray]:
    """Return the rows of each position, turn, rest and statement."""
    keys = dict[tuple[object, ...], list[int]]()
    for row, number in enumerate(evidence.step.tolist()):
        if number >= 0:
            step = evidence.seen.steps[number]
            name = step.position if step.kind == "dwell" else step.name
            keys.setdefault((step.campaign, step.kind, name), []).append(row)
        elif not evidence.is_range[row]:
            keys[row,] = [row]
    return [np.array(rows) for rows in keys.values()]


def campaign_groups(evidence: Evidence) -> list[IntArray]:
    """Return the measured rows of each campaign, where there are several."""
    of_step = np.array([step.campaign for step in evidence.seen.steps])
    of_row = np.where(evidence.is_data, of_step[evidence.step], -1)
    found = [np.flatnonzero(of_row == number) for number in np.unique(of_step)]
    return found if len(found) > 1 else []
