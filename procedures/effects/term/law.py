"""The equation of an effect, written once; columns, corrections, exports, LaTeX and reference are made from it.

    added = c_1 term_1 + c_2 term_2 + ...       coefficients of its own for every sensor

A polynomial is one term with the exponent ``n``, as ``T**n * out``; each sensor has its own order. ``c`` inside a
term is the sensor's coefficient, where the effect is not linear in it.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import inf, isclose, isfinite, pi

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import Columns, Excitation, with_nonlinear
from procedures.effects.term.dimensions import COEFFICIENT, CONSTANTS
from procedures.effects.term.functions import OPERATORS
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, calls, names, parse
from procedures.effects.term.inputs import MEASURED, Input, known_input
from procedures.effects.term.units import parse_unit, power_of
from procedures.effects.term.values import Values, evaluated
from procedures.frames import AXES

OUTPUT_UNITS = {"accelerometer": "g", "gyroscope": "deg/s"}
EXPONENT = "**n"  # of a polynomial's term
SPAN_K = 30.0  # from the reference, at which all powers of a polynomial may add as much
MAX_ORDER = 6
STARTS = (3, 6, 12, 24, 48)  # of a search over one parameter; the square root of the last of each of two
MIN_CORRELATION = 0.8  # of neighbours


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a term has in addition to its coefficient: between ``low`` and ``high``, above zero, in ``unit``."""

    unit: str
    low: float = 0.0
    high: float = inf


@dataclass(frozen=True, slots=True)
class Law:
    """What an effect adds to the output of ``triad``, "accelerometer" or "gyroscope".

    ``unit`` is that of a coefficient, of a polynomial that of the first, ``plausible`` its 1 sigma. ``shape``
    names one of several laws of an effect. ``suffixes`` are what the coefficients' names have behind the sensor's,
    one a term. An effect of the catalogue fills in what its laws leave empty.
    """

    name: str = ""
    triad: str = ""
    terms: tuple[str, ...] = ()
    unit: str = ""
    plausible: float = 0.0
    source: str = ""
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    shape: str = ""
    suffixes: tuple[str, ...] = ()

    @property
    def is_polynomial(self) -> bool:
        """Say whether each sensor has its own order."""
        return EXPONENT in self.terms[0]

    def written(self, order: int = 1) -> tuple[str, ...]:
        """Return its terms, those of a polynomial up to an order."""
        if not self.is_polynomial:
            return self.terms
        powers = ["", *(f"**{n}" for n in range(2, order + 1))]
        return tuple(self.terms[0].replace(EXPONENT, power) for power in powers)

    def nodes(self, order: int = 1) -> tuple[Node, ...]:
        """Return the same, parsed."""
        return tuple(map(parse, self.written(order)))

    @property
    def equation(self) -> str:
        """What it adds, as text."""
        if self.is_inside:
            return self.terms[0]
        texts, end = (self.written(2), " + ...") if self.is_polynomial else (self.terms, "")
        several = len(texts) > 1
        return " + ".join(f"c{i + 1 if several else ''} ({term})" for i, term in enumerate(texts)) + end

    @property
    def is_inside(self) -> bool:
        """Say whether its coefficient stands inside its term."""
        return any(each.name == COEFFICIENT for node in self.nodes() for each in names(node))

    @property
    def coefficients(self) -> tuple[str, ...]:
        """Their names, of a polynomial those of straight lines."""
        return self.keys((1, 1, 1))

    def keys(self, orders: Sequence[int]) -> tuple[str, ...]:
        """Return the coefficients' names: x, y, z of one term, else x.1, x.2, ..., y.1, ..., or with suffixes."""
        if self.suffixes:
            return tuple(axis + suffix for axis in AXES for suffix in self.suffixes)
        of_axis = orders if self.is_polynomial else (len(self.terms),) * len(AXES)
        if max(of_axis) == 1:
            return tuple(AXES)
        return tuple(f"{axis}.{n}" for axis, most in zip(AXES, of_axis, strict=True) for n in range(1, most + 1))

    def table(self, values: Mapping[str, float]) -> FloatArray:
        """Return coefficients (3, terms), a row a sensor, each in its own unit; those without a value are zero."""
        if not self.is_polynomial:
            return np.array([values.get(key, 0.0) for key in self.coefficients]).reshape(
                len(AXES), len(self.terms)
            )
        most = max(orders_of([key for key in values if key not in self.parameters]))
        first = [[values.get(f"{axis}.1", values.get(axis, 0.0))] for axis in AXES]
        more = [[values.get(f"{axis}.{n}", 0.0) for n in range(2, most + 1)] for axis in AXES]
        return np.hstack((np.array(first), np.array(more).reshape(len(AXES), most - 1)))

    @property
    def inputs(self) -> tuple[str, ...]:
        """What its terms name, but for parameters and constants."""
        found = (each.name for node in self.nodes() for each in names(node))
        known = (*self.parameters, *CONSTANTS, COEFFICIENT)
        return tuple(dict.fromkeys(name for name in found if name not in known))

    @property
    def driver(self) -> str:
        """What drives it: that of its first input that is not of the sensor's own input, else ``input``."""
        drivers = [self._known(name).driver for name in (MEASURED[self.triad], *self.inputs)]
        return next((one for one in drivers if one not in ("", "input", drivers[0])), "input")

    @property
    def is_of_steady_temperature(self) -> bool:
        """Say whether it depends on the temperature also while nothing changes, so that values hold at one."""
        return any(_when_steady(node, 1.0) != _when_steady(node, 0.0) for node in self.nodes())

    @property
    def looks_back(self) -> bool:
        """Say whether it depends on what one sample does not determine: its campaign, or what was before.

        A lag of the temperature is followed from sample to sample.
        """
        is_of_campaign = any(self._known(name).is_of_campaign for name in self.inputs)
        return is_of_campaign or any(map(_remembers, self.nodes()))

    def _known(self, name: str) -> Input:
        found = known_input(name, self.triad)
        assert found is not None
        return found

    def plain(self, parameters: Mapping[str, float], order: int = 1) -> tuple[FloatArray, tuple[Node, ...]]:
        """Return its terms of inputs in their units, and what each is multiplied by (terms,) with a coefficient.

        That is in the unit of the output by that of a coefficient; ``parameters`` are in their units.
        """
        sizes = {name: parameters[name] * parse_unit(one.unit).size for name, one in self.parameters.items()}
        sizes |= {COEFFICIENT: parse_unit(self.unit).size} if self.is_inside else {}
        found = [plain_term(node, self.triad, sizes) for node in self.nodes(order)]
        if self.is_inside:  # a coefficient stands in it as it is: it has its unit there
            return np.ones(len(found)), tuple(term for _, term in found)
        per = parse_unit(self.unit).size / parse_unit(OUTPUT_UNITS[self.triad]).size
        return per * np.array([factor for factor, _ in found]), tuple(term for _, term in found)

    def values(self, seen: Excitation, parameters: Mapping[str, float], order: int = 1) -> FloatArray:
        """Return what a unit of a coefficient adds (n, 3, terms) [g], [deg/s]; nan where it is not known.

        ``parameters`` are in their units.
        """
        per, terms = self.plain(parameters, order)
        at = Values(seen, self.triad, {}, in_bases=False)
        with np.errstate(all="ignore"):  # what is not finite is looked for by those who ask
            found = [np.broadcast_to(at.of(node), (len(seen.f), len(AXES))) for node in terms]
            return per * np.stack(found, axis=2)

    def missing(self, seen: Excitation) -> tuple[str, ...]:
        """Return the inputs that an excitation does not have, or not everywhere."""
        return tuple(name for name in self.inputs if not self._is_known(name, seen))

    def _is_known(self, name: str, seen: Excitation) -> bool:
        return bool(np.isfinite(self._known(name).in_bases(seen, self.triad)).all())

    def at(self, seen: Excitation, way: Columns) -> Columns:
        """Return its columns where orders and parameters are as in a way."""
        orders = (way.orders or (1,) * len(AXES)) if self.is_polynomial else ()
        value = self.values(seen, way.nonlinear, max(orders, default=1))
        of_axis = orders or (len(self.terms),) * len(AXES)
        own = [(sensor, n) for sensor, most in enumerate(of_axis) for n in range(most)]
        part = np.zeros((len(value), len(AXES), len(own)))
        for column, (sensor, n) in enumerate(own):
            part[:, sensor, column] = value[:, sensor, n]
        accel, gyro = (part, None) if self.triad == "accelerometer" else (None, part)
        parameters = {name: way.nonlinear[name] for name in self.parameters}
        found = replace(
            way, coefficients=self.keys(orders), accel=accel, gyro=gyro, orders=orders, nonlinear=parameters
        )
        return with_nonlinear(
            found, tuple(self.plausible / SPAN_K ** (n if self.is_polynomial else 0) for _, n in own)
        )

    def starts(self, seen: Excitation) -> Iterator[Columns]:
        """Yield where a search over its parameters begins: so close that no minimum hides between."""
        grids = [self._grid(seen, name) for name in self.parameters]
        for values in itertools.product(*grids):
            yield Columns((), shape=self.shape, nonlinear=dict(zip(self.parameters, values, strict=True)))

    def _grid(self, seen: Excitation, name: str) -> list[float]:
        """Return values of a parameter between which its columns change little, the others in their middle."""
        one = self.parameters[name]
        middle = {key: float(np.sqrt(each.low * each.high)) for key, each in self.parameters.items()}
        most = STARTS[-1] if len(self.parameters) == 1 else int(np.sqrt(STARTS[-1]))
        grid = [one.low]
        for count in (n for n in STARTS if n <= most and one.high > one.low):
            grid = np.geomspace(one.low, one.high, count).tolist()
            shapes = [self.values(seen, {**middle, name: value}).ravel() for value in grid]
            if all(alike(a, b) for a, b in itertools.pairwise(shapes)):
                break
        return grid

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The ranges of those parameters that have one."""
        return {name: (one.low, one.high) for name, one in self.parameters.items() if isfinite(one.high)}


def orders_of(keys: Sequence[str]) -> tuple[int, ...]:
    """Return the orders (3,) that the names of a polynomial's coefficients stand for."""
    parts = [key.partition(".") for key in keys]
    return tuple(max([int(n or 1) for name, _, n in parts if name == axis], default=1) for axis in AXES)


def alike(a: FloatArray, b: FloatArray) -> bool:
    """Say whether columns ``a`` and ``b`` (n,), in one unit, are so alike that no minimum hides between them."""
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if not size:  # zero is like zero alone: next to it there may be a cliff
        return not (a.any() or b.any())
    return not np.isfinite(size) or float(a @ b) >= MIN_CORRELATION * size


def _when_steady(node: Node, T: float) -> float:
    """Return a node's value at a temperature that has stood long, all else 1."""

    def operator(call: Call) -> FloatArray | None:
        if call.name == "backlash":
            return np.zeros((1, 1))
        return np.full((1, 1), _when_steady(call.arguments[0], T)) if call.name in OPERATORS else None

    return float(evaluated(node, lambda name: np.full((1, 1), T if name == "T" else 1.0), operator)[0, 0])


def _is_lag_of_temperature(call: Call) -> bool:
    return call.name == "lag" and isinstance(call.arguments[0], Name) and call.arguments[0].name == "T"


@cache
def _remembers(node: Node) -> bool:
    """Say whether a node looks back in time, other than by a lag of the temperature."""
    return any(each.name in OPERATORS and not _is_lag_of_temperature(each) for each in calls(node))


Factored = tuple[float, Node | None]  # a factor, and what it multiplies: None is 1
ZERO, ONE = Number(0.0, ""), Number(1.0, "")
SAME = 1e-14  # relative: what rounding makes of a unit times its inverse
SCALED = ("abs", "min", "max")  # f(k x, k y) = k f(x, y) for k > 0


def plain_term(node: Node, triad: str, sizes: Mapping[str, float]) -> tuple[float, Node]:
    """Return a factor and a term of a triad, of inputs in their units: together the term in the bases.

    ``sizes`` are in the bases the parameters, and the unit of a coefficient inside the term.
    """
    with np.errstate(all="ignore"):  # what is not finite is looked for by those who ask
        factor, term = _Plain(triad, sizes).of(node)
    return factor, term or ONE


class _Plain:
    def __init__(self, triad: str, sizes: Mapping[str, float]) -> None:
        self.triad, self.sizes = triad, sizes

    def of(self, node: Node) -> Factored:
        match node:
            case Number():
                return node.value * (parse_unit(node.unit).size if node.unit else 1.0), None
            case Name(name="pi"):
                return pi, None
            case Name(name=name) if name in self.sizes:
                return self.sizes[name], Name(name) if name == COEFFICIENT else None
            case Name(name=name):
                return self.size(name), Name(name)
            case Operation():
                return self.operation(node)
        return self.call(node)

    def size(self, name: str) -> float:
        """Return the size of an input's unit in the bases."""
        known = known_input(name, self.triad)
        assert known is not None
        return parse_unit(known.unit).size

    def operation(self, node: Operation) -> Factored:
        left = self.of(node.left)
        if node.sign == "**":
            power = float(power_of(node.right, ""))
            if left[1] is None:
                return _power(left[0], power), None
            base = left if left[0] > 0 else (1.0, _whole(left))
            return _power(base[0], power), Operation("**", _whole((1.0, base[1])), Number(power, ""))
        right = self.of(node.right)
        match node.sign:
            case "*":
                if left[1] is None or right[1] is None:
                    return left[0] * right[0], left[1] or right[1]
                return left[0] * right[0], Operation("*", left[1], right[1])
            case "/":
                term = left[1] if right[1] is None else Operation("/", left[1] or ONE, right[1])
                return float(np.float64(left[0]) / right[0]), term
        return self.sum(node.sign, left, right)

    def sum(self, sign: str, left: Factored, right: Factored) -> Factored:
        by = 1.0 if sign == "+" else -1.0
        if not left[0] or not right[0]:
            return right if not left[0] and by > 0 else (by * right[0], right[1]) if not left[0] else left
        if left[1] is None and right[1] is None:
            return left[0] + by * right[0], None
        if isclose(left[0], right[0], rel_tol=SAME):
            return left[0], Operation(sign, left[1] or ONE, right[1] or ONE)
        return 1.0, Operation(sign, _whole(left), _whole(right))

    def call(self, node: Call) -> Factored:
        if node.name in {"lag", "smooth", "backlash"}:
            factor, what = self.of(node.arguments[0])
            time = Number(self.of(node.arguments[1])[0], "")
            if node.name == "backlash":
                return 1.0, Call(node.name, (_whole((factor, what)), time))
            return factor, Call(node.name, (what or ONE, time))
        each = [self.of(argument) for argument in node.arguments]
        common = {factor for factor, what in each if factor or what is not None}
        if node.name in SCALED and len(common) == 1 and 0 < (factor := common.pop()) < inf:
            return factor, Call(node.name, tuple(_whole((f / factor, what)) for f, what in each))
        if node.name == "sign" and each[0][0] > 0:
            return 1.0, Call("sign", (each[0][1] or ONE,))
        return 1.0, Call(node.name, tuple(map(_whole, each)))


def _power(base: float, power: float) -> float:
    return float(np.power(np.float64(base), power))


def _whole(one: Factored) -> Node:
    factor, term = one
    if term is None:
        return Number(factor, "")
    return term if isclose(factor, 1.0, rel_tol=SAME) else Operation("*", Number(factor, ""), term)
