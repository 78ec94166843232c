"""A term of plain numbers and inputs in their own units, and the factor before it.

In the bases of `procedures.effects.term.units` a rate of 1 deg/s is 0.017 rad/s. What is constant is taken before
the term as far as it can be, so that terms of one form are equal whatever their units and numbers.
"""

from collections.abc import Mapping
from math import inf, isclose, pi

import numpy as np

from procedures.effects.term.dimensions import COEFFICIENT
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation
from procedures.effects.term.inputs import known_input
from procedures.effects.term.units import parse_unit, power_of

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
