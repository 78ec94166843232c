"""Moves between placings as evidence: how an effect turns the rotation that the gyroscopes' samples add up to.

What adds g(t) [deg/s] to the gyroscopes' E u + D turns a move by ``sum of C E^-1 g dt``, C from each sample to the
move's end. What turns the placings by small rotations p0 and p1, before the move and after it, must be turned by
the move too, which carries one into the other by R: the rows see ``R p0 - p1``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.sample_records import Series
from procedures.diagnosis.excitation import Bins, NodeBuilder, StepNodes, attitude, site_vectors
from procedures.effects.effect import ExcitationStep
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

    ``placed`` are the nodes of the placings that the moves are between.
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
