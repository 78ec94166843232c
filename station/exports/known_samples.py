"""Test samples with known results for generated programs, and how many iterations these need."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.sagnac_sine import sine_less_one
from procedures.effects.term.functions import FUNCTIONS
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, names
from procedures.frames import AXES, TRIADS
from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.correction_inputs import Surroundings, TemperatureFollower, Triad
from station.errors import DataRefused
from station.exports.exported_calibration import CarriedEffect, StoredCalibration, input_name
from station.exports.expressions import OWN

Vectors = dict[str, FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """What n samples are worked out from: what a triad reads (n, 3) [g], [deg/s], and all else by name.

    ``known`` has T, T_rate, warming and auxiliary channels (n, 1), B (n, 3), ``behind`` what lags by its tau.
    """

    read: Mapping[str, FloatArray]
    known: Mapping[str, FloatArray]
    behind: Mapping[float, FloatArray]


def settle(
    triads: Mapping[str, Triad], effects: Sequence[CarriedEffect], inputs: Inputs, rounds: int
) -> list[Vectors]:
    """Return u of each triad (n, 3) [g], [deg/s] after no round, one, two, ..."""
    out = dict(inputs.read)
    found = [_inverted(triads, out)]
    for _ in range(rounds):
        seen = {"f": found[-1].get("accelerometer"), "omega": found[-1].get("gyroscope")}
        vectors = {name: value for name, value in seen.items() if value is not None}
        added = {name: np.zeros_like(value) for name, value in out.items()}
        for effect in effects:
            at = _Term({**inputs.known, **vectors, "out": out[effect.triad]}, inputs.behind, effect.triad)
            for column, term in enumerate(effect.terms):
                c = effect.coefficients[:, column]
                inside = any(each.name == "c" for each in names(term))
                added[effect.triad] += at.of(term, c) * (1.0 if inside else c)
        out = {name: inputs.read[name] - added[name] for name in out}
        found.append(_inverted(triads, out))
    return found


def _inverted(triads: Mapping[str, Triad], out: Mapping[str, FloatArray]) -> Vectors:
    return {name: (out[name] - triad.D) @ triad.inverse.T for name, triad in triads.items()}


@dataclass(frozen=True, slots=True, eq=False)
class _Term:
    known: Mapping[str, FloatArray]
    behind: Mapping[float, FloatArray]
    triad: str

    def of(self, node: Node, c: FloatArray) -> FloatArray:
        """Return a term's value, which broadcasts to (n, 3)."""
        match node:
            case Number():
                return np.array([[node.value]])
            case Name(name="c"):
                return c
            case Name():
                return self._name(OWN[self.triad] if node.name == "u" else node.name)
            case Operation():
                left, right = self.of(node.left, c), self.of(node.right, c)
                operation = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": np.power}
                found: FloatArray = operation[node.sign](left, right)
                return found
            case Call(name="lag", arguments=(_, Number(value=tau))):
                return self.behind[tau]
            case Call(name="sine", arguments=(inner,)):
                return sine_less_one(self.of(inner, c))
            case Call():
                return FUNCTIONS[node.name].value(*(self.of(each, c) for each in node.arguments))

    def _name(self, name: str) -> FloatArray:
        if name in self.known:
            return self.known[name]
        vector, _, part = name.partition("_")
        value = self.known[vector]
        if part == "norm":
            return np.asarray(np.linalg.norm(value, axis=1, keepdims=True))
        if part in AXES:
            return value[:, AXES.index(part)][:, None]
        return value[:, [(i + int(part) - 1) % 3 for i in range(3)]]


RANGE_G, RANGE_DEG_S = 5.0, 400.0  # within which a fixed number of rounds is held to its residual
MAX_PHASE = 0.8  # rad of a Sagnac sine at the end of that range
USUAL_C = (0.0, 50.0)  # degC, where a calibration does not say at which temperatures it was measured
MAGNETIC_UT = (20.0, -5.0, 40.0)
AUXILIARY = 1.5
MAX_ROUNDS = 60
MOST_LEFT = 0.01  # of the input's length after these: more is no correction
INTERVAL_S = 15.0  # of the samples that are tried
TRIED, HALF = 1000, 6  # samples: random ones, and of each half of the self-test
INTERVALS_S = (1 / 128, 0.5, 2.0, 8.0, 16.0, 32.0)  # of the self-test's samples, which float holds exactly


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """A sample of the self-test: ``counts`` (6,), of gyroscopes and accelerometers, and what comes of them.

    Temperature [degC], ``dt_s`` [s], ``force`` (3,) [g] and ``rate`` (3,) [deg/s]; nan of an absent triad.
    """

    counts: FloatArray
    temperature: float
    dt_s: float
    force: FloatArray
    rate: FloatArray


@dataclass(frozen=True, slots=True)
class Rounds:
    """A fixed number of rounds, and what it leaves: the largest error as a part of the input's length."""

    number: int
    residual: float
    range_g: float
    range_deg_s: float

    def __str__(self) -> str:
        reach = f"up to {self.range_g:g} g and {self.range_deg_s:.3g} deg/s"
        return f"{self.residual:.1e} of the input's length is left after {self.number} rounds, {reach}"


def rounds_needed(stored: StoredCalibration, effects: Sequence[CarriedEffect], wanted: float) -> Rounds:
    """Return how many rounds leave less than ``wanted`` of the input's length, or the most that are taken.

    Raises
    ------
    DataRefused
        If an effect has no finite value within the range.
    """
    rate = _range_deg_s(effects)
    if not effects:
        return Rounds(0, 0.0, RANGE_G, rate)
    rng = np.random.default_rng(1)
    low, high = stored.temperature_range_c or USUAL_C
    T = np.sort(rng.uniform(low, max(high, low + 1.0), TRIED))
    t = INTERVAL_S * np.arange(TRIED, dtype=np.float64)
    inputs = {name: rng.uniform(-1, 1, (TRIED, 3)) * (RANGE_G if name == TRIADS[0] else rate) for name in TRIADS}
    output = {name: inputs[name] @ triad.E.T + triad.D for name, triad in stored.triads.items()}
    expected = _by_station(stored, effects, output, T, t)
    known = _known(effects, T, t)
    best = Rounds(0, np.inf, RANGE_G, rate)
    with np.errstate(all="ignore"):  # what is not finite is no residual
        tried = settle(stored.triads, effects, Inputs(output, *known), MAX_ROUNDS)
    for number, found in enumerate(tried):
        best = Rounds(number, _apart(found, expected), RANGE_G, rate)
        if number and best.residual < wanted:
            break
    if not best.residual < MOST_LEFT:
        what = f"error terms that do not converge up to {RANGE_G:g} g and {rate:.3g} deg/s"
        raise DataRefused(
            stored.path, None, what, "error terms that are small against the input", "solve it again"
        )
    return best


def known_samples(stored: StoredCalibration, effects: Sequence[CarriedEffect], *, is_float: bool) -> list[Sample]:
    """Return two runs of samples, warming and cooling, from equilibrium, with what the station makes of them."""
    rng = np.random.default_rng(2)
    low, high = stored.temperature_range_c or USUAL_C
    number = np.float32 if is_float else np.float64
    found = list[Sample]()
    for direction in (1.0, -1.0):
        T = (
            np.linspace(low, max(high, low + 2.0 * HALF), HALF)
            .astype(number)
            .astype(np.float64)[:: int(direction)]
        )
        dt = np.array(INTERVALS_S)
        inputs = {TRIADS[0]: rng.uniform(-1.2, 1.2, (HALF, 3)), TRIADS[1]: rng.uniform(-1, 1, (HALF, 3))}
        inputs[TRIADS[1]] *= min(100.0, _range_deg_s(effects))
        counts = {
            name: (triad.k * (inputs[name] @ triad.E.T + triad.D) * dt[:, None]).astype(number).astype(np.float64)
            for name, triad in stored.triads.items()
        }
        read = {name: counts[name] / dt[:, None] / triad.k for name, triad in stored.triads.items()}
        u = _by_station(stored, effects, read, T, np.cumsum(dt))
        both = [counts.get(name, np.zeros((HALF, 3))) for name in TRIADS]
        force, rate = (u.get(name, np.full((HALF, 3), np.nan)) for name in TRIADS)
        found += [
            Sample(np.hstack((both[1][i], both[0][i])), float(T[i]), float(dt[i]), force[i], rate[i])
            for i in range(HALF)
        ]
    return found


def _by_station(
    stored: StoredCalibration,
    effects: Sequence[CarriedEffect],
    read: Mapping[str, FloatArray],
    T: FloatArray,
    t: FloatArray,
) -> Vectors:
    """Return u (n, 3) [g], [deg/s] as the station applies the carried effects to what triads read."""
    carried = [entry for entry in stored.effects if any(one.entry is entry for one in effects)]
    document = {**stored.document, "effects": carried}
    n = len(T)
    channels = {input_name(name) for one in effects for name in one.inputs if name.startswith("aux_")}
    around = Surroundings(
        temperature=T, t=t, magnetic=np.tile(MAGNETIC_UT, (n, 1)),
        auxiliary={name: np.full(n, AUXILIARY) for name in channels},
    )  # fmt: skip
    rates = [read[name] * stored.triads[name].k if name in stored.triads else None for name in TRIADS]
    with np.errstate(all="ignore"):  # what is not finite is refused below
        found = calibrated_inputs(document, rates[0], rates[1], around)
    u = {name: one for name, one in zip(TRIADS, (found.f, found.omega), strict=True) if one is not None}
    if found.not_applied or not all(np.isfinite(one).all() for one in u.values()):
        what = found.not_applied[0] if found.not_applied else "an effect without a finite value"
        raise DataRefused(stored.path, None, what, "error terms that samples determine", "solve it again")
    return u


def _known(
    effects: Sequence[CarriedEffect], T: FloatArray, t: FloatArray
) -> tuple[dict[str, FloatArray], dict[float, FloatArray]]:
    names = {name for one in effects for name in one.inputs if name.startswith("aux_")}
    found = TemperatureFollower(tuple(tau for one in effects for tau in one.lags)).take(t, T)
    known = {
        "T": found.warmth[:, None], "T_rate": found.rate[:, None], "warming": found.direction[:, None],
        "B": np.tile(MAGNETIC_UT, (len(T), 1)), **{name: np.full((len(T), 1), AUXILIARY) for name in names},
    }  # fmt: skip
    return known, {tau: value[:, None] for tau, value in found.lagged.items()}


def _range_deg_s(effects: Sequence[CarriedEffect]) -> float:
    """Return up to which rate [deg/s] a fixed number of rounds is tried: a sine can be undone up to its bend."""
    q = [np.abs(one.coefficients).max() for one in effects if one.name == "gyroscope.sagnac_sine"]
    return float(min([RANGE_DEG_S, *(MAX_PHASE / np.sqrt(each) for each in q if each > 0)]))


def _apart(found: Vectors, expected: Vectors) -> float:
    worst = 0.0
    for name, true in expected.items():
        with np.errstate(all="ignore"):
            error = np.linalg.norm(found[name] - true, axis=1) / np.linalg.norm(true, axis=1)
        worst = max(worst, float(error.max()) if np.isfinite(error).all() else np.inf)
    return worst
