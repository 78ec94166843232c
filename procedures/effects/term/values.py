"""A term's value at the nodes of every step, in the bases of `procedures.effects.term.units`."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import REFERENCE_C, Excitation
from procedures.effects.temperature_history import sensor_temperature
from procedures.effects.term.functions import FUNCTIONS, OPERATORS, over_time
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation
from procedures.effects.term.inputs import input_of
from procedures.effects.term.units import parse_unit


def fixed(node: Node, parameters: Mapping[str, float]) -> float:
    """Return a number or a parameter, ``parameters`` in the bases, in these."""
    if isinstance(node, Number):
        return node.value * (parse_unit(node.unit).size if node.unit else 1.0)
    assert isinstance(node, Name)
    return parameters[node.name]


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """Evaluates terms of a triad in one excitation; ``parameters`` are in the bases.

    The terms were checked by `procedures.effects.term.dimensions` before.
    """

    seen: Excitation
    triad: str
    parameters: Mapping[str, float]

    def of(self, node: Node) -> FloatArray:
        """Return a node's value, which broadcasts to (n, 3); nan where it is not known."""
        match node:
            case Number():
                return np.array([[fixed(node, self.parameters)]])
            case Name(name=name):
                return self._name(name)
            case Operation():
                return self._operation(node)
            case Call():
                return self._operator(node) if node.name in OPERATORS else self._function(node)

    def _name(self, name: str) -> FloatArray:
        if name == "pi":
            return np.full((1, 1), np.pi)
        if name in self.parameters:
            return np.full((1, 1), self.parameters[name])
        found = input_of(name, self.triad)
        assert found is not None
        return found.in_bases(self.seen, self.triad)

    def _operation(self, node: Operation) -> FloatArray:
        left, right = self.of(node.left), self.of(node.right)
        match node.sign:
            case "+":
                return left + right
            case "-":
                return left - right
            case "*":
                return left * right
            case "/":
                return left / right
        found: FloatArray = left**right
        return found

    def _function(self, node: Call) -> FloatArray:
        return FUNCTIONS[node.name].value(*map(self.of, node.arguments))

    def _operator(self, node: Call) -> FloatArray:
        what, time = node.arguments
        tau = fixed(time, self.parameters)
        if node.name == "lag" and isinstance(what, Name) and what.name == "T":
            return (sensor_temperature(self.seen, tau) - REFERENCE_C)[:, None]
        x = self.of(what)
        whole = np.broadcast_to(x, (len(self.seen.t), x.shape[1]))
        return over_time(node.name, self.seen, whole, tau)
