"""What terms are made of: inputs of `effect/1`, and functions of one input with a parameter on a coarse grid.

Every factor is the same for the three sensors (own, next, last axis): a term keeps the triad's symmetry.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import Excitation
from procedures.effects.term.grammar import channel_as_written, parse
from procedures.effects.term.inputs import AUXILIARY, inputs_of
from procedures.effects.term.units import parse_unit
from procedures.effects.term.values import Values

WITH_AXES = ("", "_2", "_3")
SCALARS = ("T", "T_rate", "t")
THERMAL = ("T", "T_rate")  # where nothing grows warmer a rate is rounding
PER_UNIT = {"s": "h"}  # a coefficient is given by the hour
FEWEST_K = 0.5  # K by which a temperature must move to be an input
TIMES = 6  # of a grid of time constants
ZONE_RATIO = 1.25  # between neighbours of a grid of widths of a zone of the input
MOST_WAVES = 24  # of a grid of periods


@dataclass(frozen=True, slots=True)
class Shape:
    """A parameter's value, and between what it is fitted, in ``unit``."""

    unit: str
    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Factor:
    """A factor of a term: ``text`` in the grammar, the unit of a coefficient's divisor, how complex it is."""

    text: str
    unit: str = ""
    weight: float = 1
    shape: Mapping[str, Shape] = field(default_factory=dict)

    def values(self, seen: Excitation, triad: str) -> FloatArray:
        """Return its value at the nodes (n, 3) or (n, 1), in the bases of units."""
        parameters = {name: one.value * parse_unit(one.unit).size for name, one in self.shape.items()}
        with np.errstate(all="ignore"):
            return Values(seen, triad, parameters).of(parse(self.text))


def inputs_seen(seen: Excitation, triad: str) -> list[Factor]:
    """Return the inputs that a campaign knows and that move in it, each a factor."""
    vectors = [*(f"f{axis}" for axis in WITH_AXES), *(f"B{axis}" for axis in WITH_AXES)]
    if triad == "gyroscope":
        vectors += ["u", "omega_2", "omega_3"]
    else:
        vectors = ["u", *vectors[1:]]
    names = [*vectors, *SCALARS, "f_before", "north", "east"]
    channels = [channel_as_written(f"{AUXILIARY}{name}") for name in seen.auxiliary]
    names += [name for name in channels if name is not None]
    found = list[Factor]()
    for name in names:
        unit = "unit" if name in channels else inputs_of(triad)[name].unit
        one = Factor(name, "" if unit == "1" else PER_UNIT.get(unit, unit))
        value = one.values(seen, triad)
        is_seen = _moves(seen) if name in THERMAL else np.ptp(value, axis=0).max() > 0
        if np.isfinite(value).all() and is_seen:
            found.append(one)
    return found


def shapes_of_time(seen: Excitation, triad: str) -> Iterator[Factor]:
    """Yield functions of time, of time at rest, and what follows temperature or turning."""
    lasts, rests = float(np.ptp(seen.t)), float(np.nanmax(seen.rest_s))
    for tau in _grid(lasts / 40, lasts, TIMES):
        yield Factor("exp(-t / tau)", "", 2, tau)
    for tau in _grid(rests / 30, rests, TIMES):
        yield Factor("exp(-t_step / tau)", "", 2, tau)
        yield Factor("(1 - exp(-t_step / tau))", "", 2, tau)
    for tau in _grid(rests / 100, rests / 5, 3):
        yield Factor("log(1 + t_step / tau)", "", 2, tau)
    if _moves(seen):
        for tau in _grid(lasts / 40, lasts, TIMES):
            yield Factor("lag(T, tau)", "K", 2, tau)
            yield Factor("(T - lag(T, tau))", "K", 2, tau)
    if triad == "gyroscope":
        for tau in _grid(lasts / 40, lasts, TIMES):
            yield Factor("lag(omega_norm**2, tau)", "(deg/s)^2", 2, tau)


def shapes_of_input(seen: Excitation, triad: str) -> Iterator[Factor]:
    """Yield functions of what the sensor measures: powers, magnitudes, zones about zero, ends of a range."""
    unit = "g" if triad == "accelerometer" else "deg/s"
    u = np.abs(seen.f if triad == "accelerometer" else seen.omega)
    for text, power, weight in (
        ("abs(u)", 1, 2), ("u * abs(u)", 2, 2), ("abs(u)**3", 3, 3), ("u**4", 4, 2.5), ("u**5", 5, 3),
        ("sign(u)", 0, 2),
    ):  # fmt: skip
        yield Factor(text, unit if power == 1 else f"({unit})^{power}" if power else "", weight)
    slowest = _slowest_turn(seen) if triad == "gyroscope" else np.inf
    for width in _widths(u, unit):
        # a zone wider than the slowest turn is a bend of the slow turns, with a scale factor of the fast ones
        for x in ("u", "out") if width["w"].high < slowest else ():
            yield Factor(f"{x} * exp(-({x} / w)**4)", unit, 2, width)
            yield Factor(f"tanh({x} / w)", "", 2, width)
            yield Factor(f"({x} - sign({x}) * sqrt(max(0, {x}**2 - w**2)))", unit, 3, width)
        yield Factor("sign(u) * max(0, abs(u) - w)", unit, 2, width)


def _slowest_turn(seen: Excitation) -> float:
    """Return the rate [deg/s] of the slowest turn, infinite where nothing is turned."""
    rates = np.max(np.abs(seen.omega), axis=1)
    turns = [number for number, step in enumerate(seen.steps) if step.kind == "turn"]
    return min((float(np.median(rates[seen.step == number])) for number in turns), default=np.inf)


def shapes_of_vector(one: Factor) -> Iterator[Factor]:
    """Yield functions of what acts along an axis: its magnitude, its square with its sign, its sign."""
    yield Factor(f"abs({one.text})", one.unit, 2)
    yield Factor(f"{one.text} * abs({one.text})", f"({one.unit})^2", 2)
    yield Factor(f"sign({one.text})", "", 2)


def waves(seen: Excitation, triad: str) -> Iterator[tuple[Factor, Factor]]:
    """Yield sine and cosine of temperature, of time, and of an accelerometer's input."""
    T = seen.temperature
    spans = [("t", "s", float(np.ptp(seen.t)), 0.5)]
    if _moves(seen):
        spans.append(("T", "K", float(np.ptp(T)), 0.7))
    if triad == "accelerometer":
        spans.append(("u", "g", 2.0, 1.0))
    for name, unit, span, least in spans:
        for cycles in np.arange(least, MOST_WAVES / 2 + least, 0.5).tolist():
            period = span / cycles
            shape = {"P": Shape(unit, period, span / (cycles + 0.5), span / max(cycles - 0.5, 0.3))}
            both = [Factor(f"{of}(2 * pi * {name} / P)", "", 2, shape) for of in ("sin", "cos")]
            yield both[0], both[1]


def _moves(seen: Excitation) -> bool:
    T = seen.temperature
    return bool(np.isfinite(T).all() and np.ptp(T) > FEWEST_K)


def _grid(low: float, high: float, count: int) -> Iterator[Mapping[str, Shape]]:
    """Yield time constants [s], each to be fitted as far as its neighbours."""
    if 0 < low < high:
        ratio = (high / low) ** (1 / (count - 1))
        for value in np.geomspace(low, high, count).tolist():
            yield {"tau": Shape("s", value, value / ratio, value * ratio)}


def _widths(u: FloatArray, unit: str) -> Iterator[Mapping[str, Shape]]:
    """Yield widths of a zone about zero where magnitudes u (n, 3) lie, close to each other; none elsewhere."""
    felt = u[u > 0]
    if len(felt):
        here = np.unique(np.round(np.log(felt[felt >= np.quantile(felt, 0.02)]) / np.log(ZONE_RATIO)))
        for step in np.union1d(here, here + 1).tolist():
            value = ZONE_RATIO**step
            yield {"w": Shape(unit, value, value / ZONE_RATIO, value * ZONE_RATIO)}
