"""What is left out in turn: every position of a campaign, every turn and every rest, with all its repeats."""

import numpy as np

from procedures.arrays import IntArray
from procedures.diagnosis.evidence import Evidence


def groups(evidence: Evidence) -> list[IntArray]:
    """Return the rows of each position, turn and rest."""
    keys = dict[tuple[object, ...], list[int]]()
    for row, number in enumerate(evidence.step.tolist()):
        if number >= 0:
            step = evidence.seen.steps[number]
            name = step.position if step.kind == "dwell" else step.name
            keys.setdefault((step.campaign, step.kind, name), []).append(row)
    return [np.array(rows) for rows in keys.values()]
