"""Terms as expressions of C99, a sensor at a time, and of MATLAB, three sensors at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.effects.term.grammar import Call, Name, Node, Number, Operation
from procedures.effects.term.inputs import AUXILIARY
from procedures.frames import AXES
from station.calibrated.applied_effects import VECTORS as MEASURED

VECTORS = {"f": "f", "omega": "omega", "B": "state{}magnetic_ut"}
MAX_INTEGER_POWER = 12


@dataclass(frozen=True, slots=True)
class Expressions:
    """Writes terms; ``lags`` are the time constants [s] whose temperatures the program follows, in their order."""

    lags: Sequence[float]
    functions: Mapping[str, str] = field(default_factory=dict)

    def of(self, node: Node, triad: str) -> str:
        """Return the expression of a term of a triad's sensors, in the term's unit."""
        match node:
            case Number():
                return self.number(node.value)
            case Name():
                return self.name(MEASURED[triad] if node.name == "u" else node.name, triad)
            case Operation():
                return self.operation(node, triad)
            case Call(name="lag", arguments=(_, Number(value=tau))):
                return self.lagged(self.lags.index(tau))
            case Call():
                arguments = ", ".join(self.of(each, triad) for each in node.arguments)
                return f"{self.functions.get(node.name, node.name)}({arguments})"

    def name(self, name: str, triad: str) -> str:
        """Return an input; a vector's is the sensor's own component, another sensor's, or its length."""
        vector, _, part = name.partition("_")
        if name.startswith(AUXILIARY):
            return self.member(name)
        if vector in VECTORS:
            return self.component(VECTORS[vector], part)
        if name == "out":
            return self.component("accel_out" if triad == "accelerometer" else "gyro_out", "")
        if name == "c":
            return "c"
        return {"T": "warm", "T_rate": self.member("temperature_rate"), "warming": self.member("direction")}[name]

    def number(self, value: float) -> str:
        """Return a constant, in whatever unit it has."""
        raise NotImplementedError

    def member(self, name: str) -> str:
        """Return what the program's state holds, in its unit."""
        raise NotImplementedError

    def component(self, vector: str, part: str) -> str:
        """Return a vector's own component, one of another sensor, or its length, in its unit."""
        raise NotImplementedError

    def lagged(self, number: int) -> str:
        """Return a followed temperature [K] above 25 degC."""
        raise NotImplementedError

    def operation(self, node: Operation, triad: str) -> str:
        """Return two expressions joined, in their joint unit."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class CExpressions(Expressions):
    """C99 of `double`, or of `float`."""

    is_float: bool = False

    def number(self, value: float) -> str:
        """Return a constant with all its digits, in whatever unit it has."""
        return c_number(value, self.is_float)

    def member(self, name: str) -> str:
        """Return what the state holds, in its unit."""
        return f"state->{name}"

    def component(self, vector: str, part: str) -> str:
        """Return a component of sensor i, in the vector's unit."""
        vector = vector.format("->")
        if part == "norm":
            return f"length_of({vector})"
        if part in AXES and part:
            return f"{vector}[{AXES.index(part)}]"
        return f"{vector}[{'(i + ' + str(int(part) - 1) + ') % 3' if part else 'i'}]"

    def lagged(self, number: int) -> str:
        """Return a followed temperature [K] above 25 degC."""
        return f"behind[{number}]"

    def operation(self, node: Operation, triad: str) -> str:
        """Return two expressions joined, in their joint unit; a small whole power is multiplied out."""
        left, right = self.of(node.left, triad), self.of(node.right, triad)
        if node.sign != "**":
            return f"({left} {node.sign} {right})"
        match node.right:
            case Number(value=value) if value == int(value) and 0 <= value <= MAX_INTEGER_POWER:
                return f"power({left}, {int(value)})"
        return f"{self.functions['pow']}({left}, {right})"


@dataclass(frozen=True, slots=True)
class MatlabExpressions(Expressions):
    """MATLAB, columns of three sensors."""

    def number(self, value: float) -> str:
        """Return a constant with all its digits, in whatever unit it has."""
        return f"({value!r})" if value < 0 else f"{value!r}"

    def member(self, name: str) -> str:
        """Return what the state holds, in its unit."""
        return f"state.{name}"

    def component(self, vector: str, part: str) -> str:
        """Return the column of components, in the vector's unit."""
        vector = vector.format(".")
        if part == "norm":
            return f"norm({vector})"
        if part in AXES and part:
            return f"{vector}({AXES.index(part) + 1})"
        return f"{vector}([{'2 3 1' if part == '2' else '3 1 2'}])" if part else vector

    def lagged(self, number: int) -> str:
        """Return a followed temperature [K] above 25 degC."""
        return f"behind({number + 1})"

    def operation(self, node: Operation, triad: str) -> str:
        """Return two expressions joined element by element, in their joint unit."""
        sign = {"*": ".*", "/": "./", "**": ".^"}.get(node.sign, node.sign)
        return f"({self.of(node.left, triad)} {sign} {self.of(node.right, triad)})"


def c_number(value: float, is_float: bool) -> str:
    """Return a constant of C with all its digits, in whatever unit it has, in parentheses where it is negative."""
    text = str(np.float32(value)) + "F" if is_float else repr(float(value))
    return f"({text})" if value < 0 else text


def c_functions(is_float: bool) -> dict[str, str]:
    """Return the names in C of a term's functions."""
    end = "f" if is_float else ""
    same = {name: f"{name}{end}" for name in ("exp", "log", "tanh", "sqrt", "sin", "cos", "pow")}
    return {**same, "abs": f"fabs{end}", "min": f"fmin{end}", "max": f"fmax{end}", "sign": "sign_of"}
