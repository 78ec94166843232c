"""The residual as evidence: one row per thing seen, with its 1 sigma, and what the model can do about it.

Rows are in natural units (g, deg/s; deg for turns and moves): observed less modelled output over the scale factor.
A row's residual obeys, to first order,

    residual = -A dx + H c + noise

with ``A`` the model's own Jacobian (of residual by parameter, so it falls as the model rises), dx what its
parameters are off by, and H c an effect. Prior knowledge of the parameters is rows too, of no step.

Within a dwell the rate's slope and curvature are rows as well: the model predicts zero for both, and relaxation,
drift and temperature show nowhere better.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.effects.excitation import Columns, Excitation, ExcitationStep
from procedures.evidence.excitation import (
    NodeBuilder,
    StepNodes,
    SteppedRows,
    attitude,
    join_nodes,
    on_face,
    stepped_rows,
)
from procedures.evidence.row_sums import MoveWeights, NodeWeights, curvature_weights, move_parts, row_sums
from procedures.evidence.thermal_soaks import SoakBlock, SoakLevel, levels, soaks_seen
from procedures.frames import TRIADS
from procedures.positions import face_of
from procedures.twelve_positions.accelerometer_fit import RestFit, TriadFit
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit
from procedures.twelve_positions.gyroscope_model import MovesSeen
from procedures.units import STANDARD_GRAVITY

KINDS = ("mean", "slope", "curvature", "turn", "norm", "prior", "rate", "soak", "move", "level")


@dataclass(frozen=True, eq=False)
class Evidence:
    """All rows (n,): ``residual``, its 1 sigma by counting noise, ``A`` (n, p); what, where and when each is.

    ``triad`` is 0 or 1 (`TRIADS`), ``kind`` the number in `KINDS`, ``step`` that of ``excitation.steps``, -1 of
    priors, ``axis`` the sensor. ``is_range`` marks priors that only keep a parameter in bounds. ``x`` (p,) is
    where the model was linearised; ``columns_of`` says for each triad which columns of A its fit's parameters
    are. ``noise_dof`` are the degrees of freedom behind sigma, infinite where it is as good as known. ``stepped``
    are the rows that were freed of the steps of turn-ons.
    """

    residual: FloatArray
    sigma: FloatArray
    A: FloatArray
    triad: IntArray
    kind: IntArray
    step: IntArray
    axis: IntArray
    is_range: BoolArray
    x: FloatArray
    columns_of: tuple[IntArray, IntArray]
    weights: tuple[NodeWeights, ...]
    excitation: Excitation
    noise_dof: float = np.inf
    stepped: tuple[SteppedRows, ...] = ()

    def column(self, columns: Columns) -> FloatArray:
        """Return H (n, k): what a unit of each coefficient adds to every row."""
        H = np.zeros((len(self.residual), len(columns.coefficients)))
        for triad, at_nodes in enumerate((columns.accel, columns.gyro)):
            if at_nodes is not None:
                sums = row_sums(self.weights, triad, len(H), len(at_nodes))
                H += np.asarray(sums.of_sensors @ at_nodes.reshape(-1, H.shape[1]), np.float64)
                for each in sums.mixed:
                    H[each.rows] += each.of(at_nodes[each.nodes])
        if columns.rotation is not None:
            for each in self.weights:
                if each.move is not None:
                    H[each.rows] += each.move.of_ends(columns.rotation)
        for rows in self.stepped:
            rows.free(H)
        return H

    @cached_property
    def is_data(self) -> BoolArray:
        """Say of every row (n,) whether it was measured in this campaign."""
        return self.step >= 0

    @cached_property
    def is_stated(self) -> BoolArray:
        """Say of every row (n,) whether somebody stated it: a heading, a closure, a certificate, gravity."""
        return (self.step < 0) & ~self.is_range

    def rows(self, *kinds: str, triad: str | None = None) -> BoolArray:
        """Mark the rows (n,) of some kinds, and of one triad if it is named."""
        chosen: BoolArray = np.isin(self.kind, [KINDS.index(kind) for kind in kinds])
        return chosen if triad is None else chosen & (self.triad == TRIADS.index(triad))


class _Builder:
    """Collects rows and nodes of both triads; ``columns_of`` each are the columns of A of a triad's parameters.

    ``own`` columns more follow, for what belongs to single steps.
    """

    def __init__(self, columns_of: tuple[IntArray, IntArray], own: int) -> None:
        self.columns_of = columns_of
        self.first_own = 1 + max((int(c.max()) for c in columns_of if len(c)), default=-1)
        self.width = self.first_own + own
        self.parts: list[StepNodes] = []
        self.numbers: dict[ExcitationStep, int] = {}
        self.blocks: list[_Block] = []
        self.weights: list[NodeWeights] = []
        self.count = 0

    def nodes(self, part: StepNodes) -> tuple[int, slice]:
        """Return the number and the nodes of a part, taking it in if it is new."""
        if part.step not in self.numbers:
            self.numbers[part.step] = len(self.parts)
            self.parts.append(part)
        number = self.numbers[part.step]
        begin = sum(len(p.t) for p in self.parts[:number])
        return number, slice(begin, begin + len(self.parts[number].t))

    def add(self, residual: FloatArray, sigma: FloatArray, jacobian: FloatArray, triad: int, kind: str,
            step: int = -1, is_range: BoolArray | None = None, own: int | None = None,
            axis: IntArray | None = None) -> None:  # fmt: skip
        """Take in rows. ``own`` is the first of their own columns, a constant each; ``axis`` their sensors.

        Three rows are a triad's three unless that is stated.
        """
        A = np.zeros((len(residual), self.width))
        np.add.at(A.T, self.columns_of[triad][: jacobian.shape[1]], jacobian.T)
        if own is not None:
            A[:, self.first_own + own : self.first_own + own + len(A)] = -np.eye(len(A))
        is_range = np.zeros(len(residual), dtype=bool) if is_range is None else is_range
        if axis is None:
            axis = np.arange(3) if len(residual) == 3 else np.full(len(residual), -1)
        self.blocks.append(_Block(residual, sigma, A, triad, KINDS.index(kind), step, is_range, axis))
        self.count += len(residual)

    def weigh(
        self, nodes: slice, w: FloatArray | None = None, mix: FloatArray | None = None,
        move: MoveWeights | None = None, triad: int | None = None,
    ) -> None:  # fmt: skip
        """Say how the rows taken in last come about from the nodes: by their mean, where no weights are given.

        What acts on ``triad`` makes them, the rows' own where none is named.
        """
        last, size = self.blocks[-1], nodes.stop - nodes.start
        w = np.full(size, 1 / size) if w is None else w
        first = self.count - len(last.residual)
        rows = slice(first, self.count if mix is None else first + len(mix))
        self.weights.append(NodeWeights(nodes, w, rows, last.triad if triad is None else triad, mix, move))

    def evidence(self, x: FloatArray) -> Evidence:
        sizes = [len(block.residual) for block in self.blocks]
        residual, sigma, A, is_range, axis = (
            np.concatenate([getattr(b, n) for b in self.blocks])
            for n in ("residual", "sigma", "A", "is_range", "axis")
        )
        triad, kind, step = (
            np.repeat([getattr(b, n) for b in self.blocks], sizes) for n in ("triad", "kind", "step")
        )
        return Evidence(
            residual, sigma, A, triad, kind, step, axis, is_range, x, self.columns_of, tuple(self.weights),
            join_nodes(self.parts),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    residual: FloatArray
    sigma: FloatArray
    A: FloatArray
    triad: int
    kind: int
    step: int
    is_range: BoolArray
    axis: IntArray


def _columns(fits: CampaignFits) -> tuple[tuple[IntArray, IntArray], FloatArray]:
    """Return which columns of A the parameters of each triad's fit are, and where the model stands (p,).

    Slab, gravity and faces are one and the same to both triads. With moves the gyroscopes have their own: what the
    accelerometers say of them and of the seats is among their rows, as in the solve.
    """
    accel = fits.accelerometer
    gyro = fits.gyroscope.joint if fits.gyroscope is not None else None
    x = np.zeros(0) if accel is None else accel.fit.x
    first = np.arange(len(x))
    if gyro is None:
        return (first, np.zeros(0, dtype=np.int64)), x
    second = len(x) + np.arange(len(gyro.fit.x))
    has_moves = fits.gyroscope is not None and fits.gyroscope.moves is not None
    if accel is not None and not accel.is_turned_freely and not has_moves:
        shared = accel.bench.shared
        second[12 : 12 + shared] = 12 + np.arange(shared)
        second[12 + shared :] -= shared
    own = second >= len(x)
    return (first, second), np.concatenate((x, gyro.fit.x[own]))


def evidence_of(fits: CampaignFits) -> Evidence:
    """Return the rows of both triads, of those that are solved."""
    columns_of, x = _columns(fits)
    places = NodeBuilder(fits)
    soaks = soaks_seen(fits, places)
    between = levels(soaks) if fits.accelerometer is None and fits.gyroscope is None else []
    own = sum(len(blocks[0].alive) for _, blocks in soaks)
    builder = _Builder(columns_of, own + sum({each.triad: len(each.residual) for each in between}.values()))
    rested, placed = list[slice](), list[slice]()
    if fits.accelerometer is not None:
        rested = _dwells(builder, fits, places, fits.accelerometer, 0)
        if fits.accelerometer.rests is not None:
            _rests(builder, fits, places, fits.accelerometer, fits.accelerometer.rests)
        _priors(builder, fits.accelerometer, 0)
    if fits.gyroscope is not None:
        placed = _dwells(builder, fits, places, fits.gyroscope.joint, 1)
        placed += _turns(builder, places, fits.gyroscope)
        if fits.gyroscope.moves is not None:
            _moves(builder, places, fits.gyroscope.joint, fits.gyroscope.moves, placed)
        _priors(builder, fits.gyroscope.joint, 1, 3 * len(fits.gyroscope.turns), fits.gyroscope.moves)
        if fits.gyroscope.moves is not None and fits.accelerometer is not None:
            _accelerometer_rows(builder, fits.accelerometer.k, fits.gyroscope.moves.by_accelerometer, rested)
    _levels(builder, between, _soaks(builder, soaks), own)
    found = builder.evidence(np.concatenate((x, np.zeros(builder.width - builder.first_own))))
    return _at_one_bench(replace(found, stepped=stepped_rows(fits, found.rows)), fits)


def _at_one_bench(evidence: Evidence, fits: CampaignFits) -> Evidence:
    """Move the gyroscopes' residual to the accelerometers' slab and faces, of which they found nearly the same."""
    columns = evidence.columns_of[1]
    if fits.gyroscope is None or not len(columns):
        return evidence
    off = np.zeros(len(evidence.x))
    off[columns] = evidence.x[columns] - fits.gyroscope.joint.fit.x
    gyro = evidence.triad == 1
    return replace(evidence, residual=evidence.residual + gyro * (evidence.A @ off))


def _dwells(
    builder: _Builder, fits: CampaignFits, places: NodeBuilder, joint: TriadFit, triad: int
) -> list[slice]:
    """Take in the dwells' rows; return their nodes."""
    k, found = joint.k, list[slice]()
    none = np.zeros((3, 1))
    slab = (fits.accelerometer or joint).fit.x[12:]
    for i, (number, record) in enumerate(joint.seen.dwells):
        stated, tilt = fits.campaigns[number].sigma.heading, (float(slab[2 * number]), float(slab[2 * number + 1]))
        face = face_of(record.position)
        rotation = places.tilts[number, record.name]
        dwell = ExcitationStep(record.name, "dwell", number, record.position, face, stated, tilt, tilt=rotation)
        part = places.rest(number, dwell, record.series, attitude(fits.campaigns[number], record.position))
        step, nodes = builder.nodes(part)
        found.append(nodes)
        size, rows = len(part.t), slice(3 * i, 3 * i + 3)
        whitened = joint.sigma[i] / k
        residual, jacobian = joint.fit.residual[rows] * whitened, joint.fit.jacobian[rows] * whitened[:, None]
        builder.add(residual, joint.expected[i] / k, jacobian, triad, "mean", step)
        builder.weigh(nodes)
        x, half = (2 * np.arange(size) + 1) / size - 1, part.seconds.sum() / 2
        shapes = (("slope", x / np.sum(x**2) / half), ("curvature", curvature_weights(x) / half**2))
        estimates = joint.seen.estimates[i]
        if any(e.interval is not None for e in estimates):
            continue  # too few counts to determine a shape
        for kind, w in shapes:
            value = np.array([getattr(e, kind) for e in estimates]) / k
            std = np.array([getattr(e, f"{kind}_std") for e in estimates]) / k
            builder.add(value, std, none, triad, kind, step)
            builder.weigh(nodes, w)
    return found


def _rests(builder: _Builder, fits: CampaignFits, places: NodeBuilder, joint: TriadFit, found: RestFit) -> None:
    """Take in the norms; rows of up vectors on a face at an unknown heading stay with the priors."""
    inverse = np.linalg.inv(joint.K / joint.k[:, None])
    for i, (number, record) in enumerate(found.rests.rests):
        campaign = fits.campaigns[number]
        length = campaign.site.gravity / STANDARD_GRAVITY
        f = found.up[i] * length if record.up is None else on_face(campaign, record.up)
        step = ExcitationStep(record.name, "rest", number, 0, record.up or "")
        number_of, nodes = builder.nodes(places.rest(number, step, record.series, None, f))
        row = found.rows.start + i
        whitened = found.sigma[i]
        builder.add(
            joint.fit.residual[row : row + 1] * whitened, found.noise[i : i + 1],
            joint.fit.jacobian[row : row + 1] * whitened, 0, "norm", number_of,
        )  # fmt: skip
        builder.weigh(nodes, mix=(found.up[i] @ inverse)[None])


def _soaks(builder: _Builder, soaks: Sequence[tuple[str, Sequence[SoakBlock]]]) -> list[tuple[int, slice]]:
    """Take in every block of each soak and triad, with a constant of its own for every sensor alive.

    Return the number of each soak's first step, and the nodes of all its blocks.
    """
    own, found = 0, list[tuple[int, slice]]()
    for triad, blocks in soaks:
        alive = blocks[0].alive
        mix = None if len(alive) == 3 else np.eye(3)[alive]
        for block in blocks:
            step, nodes = builder.nodes(block.part)
            none, which = np.zeros((len(alive), 1)), TRIADS.index(triad)
            builder.add(block.residual[alive], block.sigma[alive], none, which, "soak", step, own=own, axis=alive)
            builder.weigh(nodes, mix=mix)
        (first, begin), (_, end) = builder.nodes(blocks[0].part), builder.nodes(blocks[-1].part)
        found.append((first, slice(begin.start, end.stop)))
        own += len(alive)
    return found


def _levels(
    builder: _Builder, between: Sequence[SoakLevel], places: Sequence[tuple[int, slice]], own: int
) -> None:
    """Take in the means of neighbouring soaks: what all of a triad's have in common is a constant."""
    common = dict[str, int]()  # the first column of each triad's constant
    for each in between:
        if each.triad not in common:
            common[each.triad], own = own, own + len(each.residual)
        first, (step, nodes) = common[each.triad], places[each.soak]
        none, which = np.zeros((len(each.residual), 1)), TRIADS.index(each.triad)
        builder.add(each.residual, each.sigma, none, which, "level", step, own=first, axis=each.axis)
        builder.weigh(nodes, mix=each.mix)


def _turns(builder: _Builder, places: NodeBuilder, gyroscope: GyroscopeFit) -> list[slice]:
    """Take in the turns' rows; return their nodes."""
    joint, found = gyroscope.joint, list[slice]()
    k = joint.k
    first = 3 * len(joint.seen.dwells)
    for i, turn in enumerate(gyroscope.turns):
        record = turn.record
        closure = gyroscope.geometry[i].closure_std
        step = ExcitationStep(
            record.name, "turn", turn.campaign, record.start_position, f"{record.axis}_up", closure
        )
        part = places.turn(turn, step)
        number, nodes = builder.nodes(part)
        rows = slice(first + 3 * i, first + 3 * i + 3)
        sigma = gyroscope.turn_sigma[i] / k
        residual, jacobian = joint.fit.residual[rows] * sigma, joint.fit.jacobian[rows] * sigma[:, None]
        builder.add(residual, sigma, jacobian, 1, "turn", number)
        builder.weigh(nodes, part.seconds)
        found.append(nodes)
    return found


def _moves(
    builder: _Builder, places: NodeBuilder, joint: TriadFit, seen: MovesSeen, placed: Sequence[slice]
) -> None:
    """Take in every move's rotation [deg]; ``placed`` are the nodes of the placements."""
    jacobian = joint.fit.jacobian[seen.rows].reshape(len(seen.error), 3, -1)
    for i, (part, weights) in enumerate(move_parts(places, joint, seen.moves, placed)):
        number, nodes = builder.nodes(part)
        sigma = np.full(3, np.degrees(seen.sigma[i]))
        whitened = joint.fit.residual[seen.rows].reshape(-1, 3)[i]
        builder.add(whitened * sigma, sigma, jacobian[i] * sigma[:, None], 1, "move", number)
        builder.weigh(nodes, part.seconds, move=weights)


def _accelerometer_rows(builder: _Builder, k: FloatArray, change: FloatArray, rested: Sequence[slice]) -> None:
    """Say what the accelerometers' dwells do to what the gyroscopes know by them, the first rows taken in last.

    ``k`` (3,) are the accelerometers' scale factors [output/s/g], ``change`` (j, 3 n) the rows' change [s/output].
    """
    for i, nodes in enumerate(rested if len(change) else ()):
        builder.weigh(nodes, mix=change[:, 3 * i : 3 * i + 3] * k, triad=0)


def _priors(
    builder: _Builder, joint: TriadFit, triad: int, turns: int = 0, moves: MovesSeen | None = None
) -> None:
    """Take in what is known of the parameters: every row of the fit that is no dwell, turn, move or norm.

    What the gyroscopes took from the accelerometers of slab and faces is left out where both have them in common.
    """
    first = 3 * len(joint.seen.dwells) + turns
    known = np.ones(len(joint.fit.residual), dtype=bool)
    known[:first] = False
    is_range = np.zeros(len(known), dtype=bool)
    is_range[first : first + len(joint.loose)] = joint.loose
    if joint.rests is not None:
        known[joint.rests.rows] = False
    if moves is not None:
        known[moves.rows] = False
    if triad == 1 and len(builder.columns_of[0]) and builder.columns_of[1][12] < len(builder.columns_of[0]):
        known[first : first + joint.bench.shared] = False
    builder.add(
        joint.fit.residual[known], np.ones(int(known.sum())), joint.fit.jacobian[known], triad, "prior", -1,
        is_range[known],
    )  # fmt: skip
