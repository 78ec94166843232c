"""An `Effect` made of terms: ``c_1 term_1 + c_2 term_2 + ...``, with coefficients of its own for every sensor.

Parameters of a term are fitted with the coefficients, by their logarithm, from a search over their ranges that is
fine enough for a minimum not to hide between: neighbours go together, or there are as many as are allowed.
"""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation
from procedures.effects.term.dimensions import CONSTANTS, Dimensions
from procedures.effects.term.functions import FUNCTIONS, OPERATORS
from procedures.effects.term.grammar import Call, Name, Node, Operation, names, parse
from procedures.effects.term.inputs import input_of
from procedures.effects.term.units import Unit, parse_unit, said
from procedures.effects.term.values import Values, fixed
from procedures.effects.time_constant import with_nonlinear
from procedures.errors import TermRefused
from procedures.frames import AXES

OUTPUT_UNITS = {"accelerometer": "g", "gyroscope": "deg/s"}
MAX_TERMS, MAX_PARAMETERS = 8, 2
STARTS = (3, 6, 12, 24, 48)  # of a search over one parameter; the square root of the last of each of two
MIN_CORRELATION = 0.8  # of neighbours
AT_END = 1e-9  # of an end of a parameter's range, within which a value stands there
SEPARATE_BY = "the campaign again in another order, with other temperatures and rates"


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a term has beside its coefficient: between ``low`` and ``high``, above nought, in ``unit``."""

    unit: str
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class TermEffect:
    """An effect as its terms say it; ``unit`` is that of a coefficient, ``plausible`` its 1 sigma in it.

    It adds to the output of ``triad``, "accelerometer" or "gyroscope".
    """

    name: str
    triad: str
    terms: tuple[str, ...]
    unit: str
    plausible: float
    source: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.parameters:
            there = (*CONSTANTS, *FUNCTIONS, *OPERATORS, *AXES)
            if name in there or input_of(name, self.triad) is not None:
                raise TermRefused(name, 0, f"a parameter {name}", "a name that no input or function has")
        powers = {name: parse_unit(one.unit).powers for name, one in self.parameters.items()}
        used = set[str]()
        for text in self.terms:
            node = parse(text)
            used |= {each.name for each in names(node)}
            adds = Unit(1.0, Dimensions(text, self.triad, powers).of(node) or parse_unit("1").powers)
            whole, wanted = (adds * parse_unit(self.unit)).powers, parse_unit(OUTPUT_UNITS[self.triad]).powers
            if whole != wanted:
                found = f"{said(whole)} of a coefficient in {self.unit} times the term"
                raise TermRefused(text, 0, found, f"{said(wanted)}, what {self.triad}s put out")
        if unused := sorted(set(self.parameters) - used):
            raise TermRefused(self.terms[0], 0, f"no {unused[0]} in it", "every parameter of [shape]")

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Its terms, parsed."""
        return tuple(map(parse, self.terms))

    @property
    def coefficients(self) -> tuple[str, ...]:
        """Their names: x, y, z of one term, else x.1, x.2, ..., y.1, ..."""
        if len(self.terms) == 1:
            return tuple(AXES)
        return tuple(f"{axis}.{i + 1}" for axis in AXES for i in range(len(self.terms)))

    @property
    def inputs(self) -> tuple[str, ...]:
        """What its terms name, parameters and constants left out."""
        found = (each.name for node in self.nodes for each in names(node))
        return tuple(dict.fromkeys(n for n in found if n not in self.parameters and n not in CONSTANTS))

    @property
    def looks_back(self) -> bool:
        """Say whether it depends on what one sample does not tell: its campaign, or what was before.

        A lag of the temperature is followed from sample to sample.
        """
        known = (input_of(name, self.triad) for name in self.inputs)
        return any(one is not None and one.is_of_campaign for one in known) or any(map(_remembers, self.nodes))

    def temperature_lags(self, parameters: Mapping[str, float]) -> tuple[float, ...]:
        """Return the time constants [s] by which it follows the temperature; ``parameters`` are in their units."""
        in_bases = self._in_bases(parameters)
        lags = (each for node in self.nodes for each in _calls(node) if _is_lag_of_temperature(each))
        return tuple(fixed(each.arguments[1], in_bases) for each in lags)

    def _in_bases(self, parameters: Mapping[str, float]) -> dict[str, float]:
        return {name: value * parse_unit(self.parameters[name].unit).size for name, value in parameters.items()}

    def values(self, seen: Excitation, parameters: Mapping[str, float]) -> FloatArray:
        """Return what a unit of a coefficient adds (n, 3, terms) [g], [deg/s]; nan where it is not known.

        ``parameters`` are in their units.
        """
        by = parse_unit(self.unit).size / parse_unit(OUTPUT_UNITS[self.triad]).size
        at = Values(seen, self.triad, self._in_bases(parameters))
        with np.errstate(all="ignore"):  # what is not finite is looked for by those who ask
            found = [np.broadcast_to(at.of(node), (len(seen.f), len(AXES))) for node in self.nodes]
            return by * np.stack(found, axis=2)

    def missing(self, seen: Excitation) -> tuple[str, ...]:
        """Return the inputs that an excitation does not have, or not everywhere."""
        return tuple(name for name in self.inputs if not self._is_known(name, seen))

    def _is_known(self, name: str, seen: Excitation) -> bool:
        known = input_of(name, self.triad)
        return known is not None and bool(np.isfinite(known.in_bases(seen, self.triad)).all())

    def at(self, seen: Excitation, way: Columns) -> Columns:
        """Return its columns where the parameters are as in a way."""
        value = self.values(seen, way.nonlinear)
        n, k = len(value), len(self.terms)
        with np.errstate(invalid="ignore"):  # infinite times nought: looked for by those who ask
            part = (value[:, :, None, :] * np.eye(len(AXES))[:, :, None]).reshape(n, len(AXES), len(AXES) * k)
        accel, gyro = (part, None) if self.triad == "accelerometer" else (None, part)
        found = Columns(self.coefficients, accel=accel, gyro=gyro, nonlinear=way.nonlinear)
        return with_nonlinear(found, (self.plausible,) * len(self.coefficients))

    def columns(self, seen: Excitation) -> list[Columns]:
        """Return its columns at every place where a search of its parameters begins; none where not known."""
        if self.missing(seen):
            return []
        found = [self.at(seen, replace(Columns(()), nonlinear=start)) for start in self._starts(seen)]
        parts = ((way, way.gyro if way.accel is None else way.accel) for way in found)
        return [way for way, part in parts if part is not None and np.isfinite(part).all()]

    def at_ends(self, values: Mapping[str, float]) -> tuple[str, ...]:
        """Say which parameters stand at an end of their range; ``values`` are in their units."""
        return tuple(
            f"{name} is at the end of its range ({one.low:g} to {one.high:g} {one.unit}): widen it"
            for name, one in self.parameters.items()
            if one.low < one.high and not one.low * (1 + AT_END) < values[name] < one.high * (1 - AT_END)
        )

    def effect(self) -> Effect:
        """Return it as a diagnosis takes it."""
        several = len(self.terms) > 1
        parts = [f"c{i + 1 if several else ''} ({term})" for i, term in enumerate(self.terms)]
        return Effect(
            name=f"{self.triad}.{self.name}", unit=self.unit, physics=" + ".join(parts), source=self.source,
            plausible=self.plausible, columns=self.columns, separate_by=SEPARATE_BY, at=self.at,
            ranges={name: (one.low, one.high) for name, one in self.parameters.items()},
        )  # fmt: skip

    def _starts(self, seen: Excitation) -> Iterator[dict[str, float]]:
        """Yield where the search of the parameters begins."""
        grids = [self._grid(seen, name) for name in self.parameters]
        for values in itertools.product(*grids):
            yield dict(zip(self.parameters, values, strict=True))

    def _grid(self, seen: Excitation, name: str) -> list[float]:
        """Return values of a parameter between which its columns change little, the others in their middle."""
        one, middle = (
            self.parameters[name],
            {k: float(np.sqrt(p.low * p.high)) for k, p in self.parameters.items()},
        )
        most = STARTS[-1] if len(self.parameters) == 1 else int(np.sqrt(STARTS[-1]))
        grid = [one.low]
        for count in (n for n in STARTS if n <= most and one.high > one.low):
            grid = np.geomspace(one.low, one.high, count).tolist()
            shapes = [self.values(seen, {**middle, name: value}).ravel() for value in grid]
            if all(_alike(a, b) for a, b in itertools.pairwise(shapes)):
                break
        return grid


def _alike(a: FloatArray, b: FloatArray) -> bool:
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if not size:  # nought is like nought alone: beside it there may be a cliff
        return not (a.any() or b.any())
    return not np.isfinite(size) or float(a @ b) >= MIN_CORRELATION * size


def _calls(node: Node) -> Iterator[Call]:
    match node:
        case Call():
            yield node
            for each in node.arguments:
                yield from _calls(each)
        case Operation():
            yield from _calls(node.left)
            yield from _calls(node.right)


def _is_lag_of_temperature(call: Call) -> bool:
    return call.name == "lag" and isinstance(call.arguments[0], Name) and call.arguments[0].name == "T"


def _remembers(node: Node) -> bool:
    """Say whether a node looks back in time, other than by a lag of the temperature."""
    return any(each.name in OPERATORS and not _is_lag_of_temperature(each) for each in _calls(node))
