"""Test samples with known results for generated programs, and how many iterations these need."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.term.grammar import calls
from procedures.effects.term.inputs import MEASURED
from procedures.frames import TRIADS
from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.applied_effects import AppliedEffect, SampleInputs
from station.calibrated.correction_inputs import Surroundings, TemperatureFollower, Triad
from station.errors import DataRefused
from station.exports.exported_calibration import StoredCalibration, input_name

Vectors = dict[str, FloatArray]


def settle(
    triads: Mapping[str, Triad], effects: Sequence[AppliedEffect], read: Vectors, known: SampleInputs, rounds: int
) -> list[Vectors]:
    """Return u of each triad (n, 3) [g], [deg/s] after no round, one, two, ..., as a program takes them.

    ``read`` is what triads read (n, 3) [g], [deg/s], ``known`` what does not change from round to round.
    """
    out = dict(read)
    found = [_inverted(triads, out)]
    for _ in range(rounds):
        vectors = {MEASURED[name]: value for name, value in found[-1].items()}
        at = replace(known, known={**known.known, **vectors}, out=out)
        added = {name: np.zeros_like(value) for name, value in out.items()}
        for effect in effects:
            added[effect.triad] += at.added(effect)
        out = {name: read[name] - added[name] for name in out}
        found.append(_inverted(triads, out))
    return found


def _inverted(triads: Mapping[str, Triad], out: Mapping[str, FloatArray]) -> Vectors:
    return {name: (out[name] - triad.D) @ triad.inverse.T for name, triad in triads.items()}


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


def rounds_needed(stored: StoredCalibration, effects: Sequence[AppliedEffect], wanted: float) -> Rounds:
    """Return how many rounds leave less than ``wanted`` of the input's length, or the most that are taken.

    Raise `DataRefused` if an effect has no finite value within the range.
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
        tried = settle(stored.triads, effects, output, known, MAX_ROUNDS)
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


def known_samples(stored: StoredCalibration, effects: Sequence[AppliedEffect], *, is_float: bool) -> list[Sample]:
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
    effects: Sequence[AppliedEffect],
    read: Mapping[str, FloatArray],
    T: FloatArray,
    t: FloatArray,
) -> Vectors:
    """Return u (n, 3) [g], [deg/s] as the station applies the carried effects to what triads read."""
    carried = [entry for entry in stored.effects if any(one.entry is entry for one in effects)]
    document = {**stored.document, "effects": carried}
    around = _around(effects, T, t)
    rates = [read[name] * stored.triads[name].k if name in stored.triads else None for name in TRIADS]
    with np.errstate(all="ignore"):  # what is not finite is refused below
        found = calibrated_inputs(document, rates[0], rates[1], around)
    u = {name: one for name, one in zip(TRIADS, (found.f, found.omega), strict=True) if one is not None}
    if found.not_applied or not all(np.isfinite(one).all() for one in u.values()):
        what = found.not_applied[0] if found.not_applied else "an effect without a finite value"
        raise DataRefused(stored.path, None, what, "error terms that samples determine", "solve it again")
    return u


def _around(effects: Sequence[AppliedEffect], T: FloatArray, t: FloatArray) -> Surroundings:
    channels = {input_name(name) for one in effects for name in one.inputs if name.startswith("aux_")}
    return Surroundings(
        temperature=T, t=t, magnetic=np.tile(MAGNETIC_UT, (len(T), 1)),
        auxiliary={name: np.full(len(T), AUXILIARY) for name in channels},
    )  # fmt: skip


def _known(effects: Sequence[AppliedEffect], T: FloatArray, t: FloatArray) -> SampleInputs:
    followed = TemperatureFollower(tuple(tau for one in effects for tau in one.lags)).take(t, T)
    return SampleInputs.of({}, {}, replace(_around(effects, T, t), signals=followed), len(T))


def _range_deg_s(effects: Sequence[AppliedEffect]) -> float:
    """Return up to which rate [deg/s] a fixed number of rounds is tried: a sine can be undone up to its bend."""
    called = {one: {call.name for term in one.terms for call in calls(term)} for one in effects}
    q = [np.abs(one.coefficients).max() for one, names in called.items() if "sine" in names]
    return float(min([RANGE_DEG_S, *(MAX_PHASE / np.sqrt(each) for each in q if each > 0)]))


def _apart(found: Vectors, expected: Vectors) -> float:
    worst = 0.0
    for name, true in expected.items():
        with np.errstate(all="ignore"):
            error = np.linalg.norm(found[name] - true, axis=1) / np.linalg.norm(true, axis=1)
        worst = max(worst, float(error.max()) if np.isfinite(error).all() else np.inf)
    return worst
