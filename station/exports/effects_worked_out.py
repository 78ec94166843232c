"""What carried effects add, worked out in numpy as a generated program does: a fixed number of rounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.sagnac_sine import sine_less_one
from procedures.effects.term.functions import FUNCTIONS
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, names
from procedures.frames import AXES
from station.calibrated.surroundings import Triad
from station.exports.carried_effects import CarriedEffect
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
