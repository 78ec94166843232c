"""How rows of evidence come about from what acts at the nodes of a step: by weights, or by sparse sums."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array

from procedures.arrays import FloatArray
from procedures.diagnosis.move_rows import MoveWeights


@dataclass(frozen=True, slots=True, eq=False)
class NodeWeights:
    """How three rows, one a sensor, come about from the nodes of a step.

    A column (m, 3, k) at the nodes becomes ``sum of w * column`` (3, k), and where there is a ``mix`` (r, 3), of
    other rows: ``mix @`` that. A ``move`` weighs by matrices in place of numbers, and by what turns its ends.
    """

    nodes: slice
    w: FloatArray
    rows: slice
    triad: int
    mix: FloatArray | None = None
    move: MoveWeights | None = None

    def of(self, values: FloatArray) -> FloatArray:
        """Return the rows (r, k) of values (m, 3, k) at the nodes."""
        if self.move is not None:
            return self.move.of(values)
        rows: FloatArray = (self.w @ values.reshape(len(values), -1)).reshape(values.shape[1:])
        return rows if self.mix is None else self.mix @ rows


@dataclass(frozen=True, slots=True, eq=False)
class RowSums:
    """How all rows (n,) come about from a triad's sensors at all nodes: as ``of_sensors`` (n, 3 nodes) sums them.

    The sensors stand node by node. What is ``mixed`` comes about by its own weights.
    """

    of_sensors: csr_array[np.float64, tuple[int, int]]
    mixed: tuple[NodeWeights, ...]


@lru_cache(maxsize=8)
def row_sums(weights: tuple[NodeWeights, ...], triad: int, rows: int, nodes: int) -> RowSums:
    """Return the sums of an evidence of so many rows and nodes: a column takes one, not one a step."""
    value, row, column = [np.zeros(0)], [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    of_triad = [each for each in weights if each.triad == triad]
    for each in of_triad:
        first, size = 3 * each.nodes.start, 3 * (each.nodes.stop - each.nodes.start)
        for sensor in range(0 if each.mix is not None else 3):
            taken = slice(None) if each.move is not None else slice(sensor, None, 3)
            column.append(np.arange(first, first + size)[taken])
            value.append(each.w if each.move is None else each.move.matrix[sensor])
            row.append(np.full(len(column[-1]), each.rows.start + sensor))
    at = np.concatenate(row), np.concatenate(column)
    of_sensors = csr_array((np.concatenate(value), at), shape=(rows, 3 * nodes))
    return RowSums(of_sensors, tuple(each for each in of_triad if each.mix is not None))
