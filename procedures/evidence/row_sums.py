"""How rows of evidence come about from what acts at the nodes of a step: by weights, or by sparse sums."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array

from procedures.arrays import FloatArray
from procedures.counts.sample_records import Series
from procedures.effects.excitation import ExcitationStep
from procedures.evidence.excitation import Bins, NodeBuilder, StepNodes, attitude, site_vectors
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.twelve_positions.placement_transfers import PlacementTransfers
from procedures.twelve_positions.transfer_rotation import LINEAR_HZ, joined_samples, rotations_to_end


@dataclass(frozen=True, slots=True, eq=False)
class MoveWeights:
    """How a move's three rows [deg] come about from its m nodes and from the nodes of both its ends.

    ``matrix`` (3, 3 m) [s] takes what is added at the nodes, node by node its three sensors; ``carried`` (3, 3) is
    the move's rotation; ``before`` and ``after`` are the nodes at which it begins and ends, of all nodes.
    """

    matrix: FloatArray
    carried: FloatArray
    before: int
    after: int

    def of(self, values: FloatArray) -> FloatArray:
        """Return rows (3, k) [deg] of values (m, 3, k) [deg/s] at the nodes."""
        return self.matrix @ values.reshape(-1, values.shape[2])

    def of_ends(self, rotations: FloatArray) -> FloatArray:
        """Return rows (3, k) [deg] of small rotations (n, 3, k) [rad] at all nodes."""
        turned: FloatArray = np.degrees(self.carried @ rotations[self.before] - rotations[self.after])
        return turned


def move_bins(series: Series) -> Bins:
    """Cut a move into bins of whole samples, 50 a second or more: shorter than a hand trembles."""
    size, n = joined_samples(series.period, LINEAR_HZ), len(series)
    return Bins(series, np.append(np.arange(0, n, size), n).astype(np.int64))


def move_parts(
    places: NodeBuilder, joint: TriadFit, moves: PlacementTransfers, placed: Sequence[slice]
) -> Iterator[tuple[StepNodes, MoveWeights]]:
    """Yield the nodes of every move, its rate as the gyroscopes measured it, with its weights.

    ``placed`` are the nodes of the placements that the moves are between.
    """
    samples, K, b = moves.finer.linear, joint.K, joint.b
    to_end, rates = rotations_to_end(samples, K, b), samples.rates(K, b)
    inverse = np.linalg.inv(K / joint.k[:, None])
    for i, record in enumerate(moves.records):
        number = int(moves.campaign[i])
        campaign, bins = places.campaigns[number], move_bins(record.series)
        C_end, omega = to_end[i, : len(bins.seconds)], rates[i, : len(bins.seconds)]
        up, _, magnetic = site_vectors(campaign)
        after = attitude(campaign, joint.bench.placements[moves.after[i]].position)
        C_sn = np.swapaxes(C_end, 1, 2) @ after
        step = ExcitationStep(record.name, "move", number, 0, "")
        part = places.part(campaign, step, bins, C_sn, C_sn @ up, omega, C_sn @ magnetic)
        matrix = C_end @ inverse * bins.seconds[:, None, None]
        yield (
            part,
            MoveWeights(
                np.swapaxes(matrix, 0, 1).reshape(3, -1), C_end[0],
                placed[moves.before[i]].stop - 1, placed[moves.after[i]].start,
            ),
        )  # fmt: skip


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


def curvature_weights(x: FloatArray) -> FloatArray:
    """Return the weights (n,) by which values at x (n,) in [-1, 1] give their parabola's second derivative."""
    P2 = (3 * x**2 - 1) / 2
    P2 -= P2.mean()
    return 3 * P2 / np.sum(P2**2)
