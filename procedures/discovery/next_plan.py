"""Which further measurement would part the readings of a proposal, by the design matrix alone.

Each option is the campaign's own steps again in another way. With the proposal as the truth, v is what it does to
the rows, there and to come; another reading, the model and new biases M leave of it

    expected chi-square = |v - M (M'M)^-1 M' v|^2

The cheapest option that parts as many readings as any is taken. Parameters of readings stay as they were fitted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.discovery.discover import Discovery, Proposal, fit_as_is
from procedures.discovery.library import Rows
from procedures.effects.excitation import Columns, Excitation, per_axis
from procedures.evidence.linear_model import Term
from procedures.evidence.residual_rows import Evidence

PARTED = 16.0  # expected chi-square by which two readings are separated
WARMER_K, HEATED_K = 5.0, 15.0
SPEEDS_DEG_S = (12.0, 25.0, 55.0, 80.0)  # of turns by hand, slow to fast
LONGER = 4.0  # times as long
MOVE_S, REVOLUTIONS = 45.0, 3.0
SECONDS_PER_MINUTE = 60.0


@dataclass(frozen=True, slots=True)
class NextMeasurement:
    """An option by its name: minutes at the bench, and the expected chi-square of each reading in order."""

    name: str
    minutes: float
    expected: tuple[float, ...]

    @property
    def parted(self) -> int:
        """How many readings it parts from the proposal."""
        return sum(each >= PARTED for each in self.expected)


@dataclass(frozen=True, slots=True)
class Option:
    """Steps of ``kinds`` again, the excitation changed; ``factors`` (n,) are on rows' columns and sigma.

    ``times`` is how much longer each step takes, (steps,) or of all.
    """

    kinds: tuple[str, ...]
    changed: Callable[[Excitation], Excitation]
    factors: Callable[[Evidence], tuple[FloatArray, FloatArray]] = lambda evidence: _ones(evidence)
    times: Callable[[Excitation], FloatArray | float] = lambda seen: 1.0


def next_measurement(found: Discovery, one: Proposal) -> NextMeasurement | None:
    """Return the cheapest option that parts most readings of a proposal; None where nothing parts any."""
    if not one.readings:
        return None
    each = [_measured(found, one, name, option) for name, option in OPTIONS.items()]
    best = max(each, key=lambda option: (option.parted, -option.minutes))
    return best if best.parted else None


def _measured(found: Discovery, one: Proposal, name: str, option: Option) -> NextMeasurement:
    evidence = found.evidence
    again = replace(evidence, excitation=option.changed(evidence.excitation))
    rows = _rows_of(evidence, option.kinds)
    if not rows.any():
        return NextMeasurement(name, 0.0, (0.0,) * len(one.readings))
    column, sigma = option.factors(evidence)
    before, after = Rows(evidence), Rows(again)
    pairs = [
        (before.of([term])[:, 0], (after.of([term])[:, 0] * (column / sigma)[:, None])[rows]) for term in one.found
    ]
    A = np.hstack([evidence.A, *(-term.H for term in found.others)]) / evidence.sigma[:, None]
    biases = _biases(evidence) * (column / sigma / evidence.sigma)[:, None]
    none = np.zeros((len(A), biases.shape[1]))
    model = np.block([[A, none], [A[rows] / sigma[rows, None], biases[rows]]])
    c = _coefficients(evidence, found.others, pairs[0][0])
    truth = np.concatenate([part @ c for part in pairs[0]])
    expected = [_left(np.hstack((model, np.concatenate(pair))), truth) for pair in pairs[1:]]
    return NextMeasurement(name, _minutes(evidence.excitation, option), tuple(expected))


def _coefficients(evidence: Evidence, others: Sequence[Term], W: FloatArray) -> FloatArray:
    fit = fit_as_is(evidence, others)
    wide = np.concatenate((W, np.zeros((len(fit.Q) - len(W), W.shape[1]))))
    found = np.linalg.lstsq(wide - fit.Q @ (fit.Q.T @ wide), fit.whole, rcond=1e-6)[0]
    return np.asarray(found, np.float64)


def _left(M: FloatArray, v: FloatArray) -> float:
    size = np.linalg.norm(M, axis=0)
    scaled = M[:, size > 0] / size[size > 0]
    return float(np.sum((v - scaled @ np.linalg.lstsq(scaled, v, rcond=1e-12)[0]) ** 2))


def _rows_of(evidence: Evidence, kinds: Sequence[str]) -> BoolArray:
    of_step = _done(evidence.excitation, kinds)
    found: BoolArray = evidence.is_data & of_step[evidence.step]
    return found


def _done(seen: Excitation, kinds: Sequence[str]) -> BoolArray:
    """Return which steps (steps,) are done again: of turns one about each axis, both ways, whatever its speed."""
    found, known = np.array([step.kind in kinds for step in seen.steps]), set[tuple[int, bool]]()
    for number in np.flatnonzero(found & _is_turn(seen)).tolist():
        rate = seen.omega[seen.step == number].sum(axis=0)
        way = int(np.argmax(np.abs(rate))), bool(rate[np.argmax(np.abs(rate))] > 0)
        found[number] = way not in known
        known.add(way)
    return found


def _ones(evidence: Evidence) -> tuple[FloatArray, FloatArray]:
    return np.ones(len(evidence.residual)), np.ones(len(evidence.residual))


def _biases(evidence: Evidence) -> FloatArray:
    """Return columns (n, 6) [g, deg/s] of biases: a unit that was switched on again has others."""
    ones = per_axis(np.ones(len(evidence.excitation.t)))
    names = ("x", "y", "z")
    return np.hstack((evidence.column(Columns(names, accel=ones)), evidence.column(Columns(names, gyro=ones))))


def _in_another_order(seen: Excitation) -> Excitation:
    """Return every dwell in the slot of another, five steps on, the room warmer."""
    t, T, rate, change = (x.copy() for x in (seen.t, seen.temperature, seen.temperature_rate, seen.change))
    nodes = [np.flatnonzero(seen.step == i) for i, step in enumerate(seen.steps) if step.kind == "dwell"]
    nodes.sort(key=lambda each: float(seen.t[each[0]]))
    order = [nodes[(5 * i + 2) % len(nodes)] for i in range(len(nodes))] if len(nodes) % 5 else nodes[::-1]
    for i, (here, slot) in enumerate(zip(order, nodes, strict=True)):
        at = np.linspace(0, 1, len(slot))
        mine = np.linspace(0, 1, len(here))
        for target, source in ((t, seen.t), (T, seen.temperature), (rate, seen.temperature_rate)):
            target[here] = np.interp(mine, at, source[slot])
        change[here] = seen.f[here[0]] - seen.f[order[i - 1][0]] if i else np.nan
    return replace(seen, t=t, temperature=T + WARMER_K, temperature_rate=rate, change=change)


def _heated(seen: Excitation) -> Excitation:
    since = (seen.t - seen.t.min()) / max(float(np.ptp(seen.t)), 1.0)
    rate = HEATED_K / max(float(np.ptp(seen.t)), 1.0) * SECONDS_PER_MINUTE
    return replace(
        seen, temperature=seen.temperature + HEATED_K * since, temperature_rate=seen.temperature_rate + rate
    )


def _is_turn(seen: Excitation) -> BoolArray:
    return np.array([step.kind == "turn" for step in seen.steps])


def _faster(seen: Excitation, speed: float) -> FloatArray:
    """Return by how much faster every step (steps,) turns at a speed [deg/s]; rests as they are."""
    found = np.ones(len(seen.steps))
    for number in np.flatnonzero(_is_turn(seen)).tolist():
        own = float(np.median(np.linalg.norm(seen.omega[seen.step == number], axis=1)))
        found[number] = speed / own if own > 0 else 1.0
    return found


def _turned_at(speed: float) -> Option:
    def changed(seen: Excitation) -> Excitation:
        times = _faster(seen, speed)[seen.step]
        return replace(
            seen, omega=seen.omega * times[:, None], gyro_output=seen.gyro_output * times[:, None],
            rest_s=seen.rest_s / times,
        )  # fmt: skip

    def factors(evidence: Evidence) -> tuple[FloatArray, FloatArray]:
        column, sigma = _ones(evidence)
        rows = evidence.rows("turn")
        column[rows] = 1 / _faster(evidence.excitation, speed)[evidence.step[rows]]
        return column, sigma

    return Option(("turn",), changed, factors, lambda seen: 1 / _faster(seen, speed))


def _longer(seen: Excitation) -> Excitation:
    return replace(seen, rest_s=seen.rest_s * LONGER)


def _of_longer(evidence: Evidence) -> tuple[FloatArray, FloatArray]:
    column, sigma = _ones(evidence)
    for kind, power in (("mean", 0), ("slope", 1), ("curvature", 2)):
        rows = evidence.rows(kind)
        column[rows], sigma[rows] = LONGER**-power, LONGER ** (-power - 0.5)
    return column, sigma


OPTIONS = {
    **{f"turns_at_{speed:g}": _turned_at(speed) for speed in SPEEDS_DEG_S},
    "another_order": Option(("dwell",), _in_another_order),
    "heated": Option(("dwell", "turn"), _heated),
    "longer_rests": Option(("dwell",), _longer, _of_longer, lambda seen: LONGER),
}


def _minutes(seen: Excitation, option: Option) -> float:
    """Return minutes at the bench: every step's own time, and a move before it."""
    lasts = np.array([np.ptp(seen.t[seen.step == number]) for number in range(len(seen.steps))])
    each = MOVE_S + option.times(seen) * lasts
    return float(np.sum(each[_done(seen, option.kinds)])) / SECONDS_PER_MINUTE
