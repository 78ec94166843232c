"""A term's value at the nodes of every step, in the bases of `procedures.effects.term.units`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import REFERENCE_C, Excitation
from procedures.effects.temperature_history import direction_or_play, sensor_temperature
from procedures.effects.term.functions import ALL_FUNCTIONS, OPERATORS, over_time
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, calls, names
from procedures.effects.term.inputs import known_input
from procedures.effects.term.units import parse_unit

APART = 1e-3  # of two time constants: closer, their difference would lose digits


def has_operator(node: Node) -> bool:
    """Say whether a node looks back in time."""
    return any(each.name in OPERATORS for each in calls(node))


def fixed(node: Node, parameters: Mapping[str, float]) -> float:
    """Return a number or a parameter, ``parameters`` in the bases, in these."""
    if isinstance(node, Number):
        return node.value * (parse_unit(node.unit).size if node.unit else 1.0)
    assert isinstance(node, Name)
    return parameters[node.name]


OPERATIONS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": np.power}


def evaluated(
    node: Node, name: Callable[[str], FloatArray], operator: Callable[[Call], FloatArray | None]
) -> FloatArray:
    """Return a node's value (n, 3), or what broadcasts to it, in the units of its names.

    ``name`` returns those (n, 3) or (n, 1), ``operator`` the same of calls that look back in time, None of others.
    """
    match node:
        case Number():
            return np.array([[fixed(node, {})]])
        case Name():
            return name(node.name)
        case Operation():
            left, right = (evaluated(each, name, operator) for each in (node.left, node.right))
            found: FloatArray = OPERATIONS[node.sign](left, right)
            return found
    known = operator(node)
    if known is not None:
        return known
    return ALL_FUNCTIONS[node.name].value(*(evaluated(each, name, operator) for each in node.arguments))


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """Evaluates terms of a triad in one excitation; ``parameters`` are in the bases, and inputs with ``in_bases``.

    The terms were checked by `procedures.effects.term.dimensions` before.
    """

    seen: Excitation
    triad: str
    parameters: Mapping[str, float]
    in_bases: bool = True

    def of(self, node: Node) -> FloatArray:
        """Return a node's value, which broadcasts to (n, 3); nan where it is not known."""
        return evaluated(node, self._name, self._operator)

    def _name(self, name: str) -> FloatArray:
        if name == "pi":
            return np.full((1, 1), np.pi)
        if name in self.parameters:
            return np.full((1, 1), self.parameters[name])
        found = known_input(name, self.triad)
        assert found is not None
        return (found.in_bases if self.in_bases else found.value)(self.seen, self.triad)

    def _operator(self, node: Call) -> FloatArray | None:
        """Return what looks back in time, None of a function."""
        if node.name == "backlash":
            return direction_or_play(self.seen, fixed(node.arguments[1], self.parameters))[:, None]
        if node.name not in OPERATORS:
            return None
        what, time = node.arguments
        tau = fixed(time, self.parameters)
        return self._lag(what, tau) if node.name == "lag" else self._over_time(node.name, what, tau)

    def _over_time(self, operator: str, what: Node, tau: float) -> FloatArray:
        x = self.of(what)
        whole = np.broadcast_to(x, (len(self.seen.t), x.shape[1]))
        return over_time(operator, self.seen, whole, tau)

    def _lag(self, what: Node, tau: float) -> FloatArray:
        """Return a lag, which is linear in what it follows: of T the time since power-on is known, else none."""
        match what:
            case Name(name="T"):
                return (sensor_temperature(self.seen, tau) - REFERENCE_C)[:, None]
            case Operation(sign="+", left=left, right=right):
                return self._lag(left, tau) + self._lag(right, tau)
            case Operation(sign="-", left=left, right=right):
                return self._lag(left, tau) - self._lag(right, tau)
            case Operation(sign="*", left=left, right=right) if self._is_constant(left):
                return self.of(left) * self._lag(right, tau)
            case Operation(sign="*" | "/", left=left, right=right) if self._is_constant(right):
                k = self.of(right)
                return self._lag(left, tau) * (k if what.sign == "*" else 1 / k)
            case Call(name="lag", arguments=(inner, time)) if not has_operator(inner):
                return self._lag_of_lag(inner, fixed(time, self.parameters), tau)
        return self._over_time("lag", what, tau)

    def _lag_of_lag(self, what: Node, a: float, b: float) -> FloatArray:
        """Return one lag of another by partial fractions: ``(a lag_a - b lag_b) / (a - b)``.

        Time constants that are nearly equal are taken `APART`, with the same mean: an error of its square.
        """
        if abs(a - b) < APART * max(a, b):
            middle = (a + b) / 2
            a, b = middle * (1 + APART / 2), middle * (1 - APART / 2)
        return (a * self._lag(what, a) - b * self._lag(what, b)) / (a - b)

    def _is_constant(self, node: Node) -> bool:
        return all(each.name == "pi" or each.name in self.parameters for each in names(node))
