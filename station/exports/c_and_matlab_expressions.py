"""Terms as expressions of C99, a sensor at a time, and of MATLAB, three sensors at once."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation
from procedures.effects.term.inputs import AUXILIARY, MEASURED
from procedures.frames import AXES

MAX_INTEGER_POWER = 12


@dataclass(frozen=True, slots=True)
class Expressions(ABC):
    """Writes terms; ``lags`` are the time constants [s] whose temperatures the program follows, in their order."""

    lags: Sequence[float]
    functions: Mapping[str, str] = field(default_factory=dict)

    def of(self, node: Node, triad: str) -> str:
        """Return the expression of a term of a triad's sensors, in the term's unit."""
        match node:
            case Number():
                return self.number(node.value)
            case Name():
                return self._name(MEASURED[triad] if node.name == "u" else node.name, triad)
            case Operation():
                return self._operation(node, self.of(node.left, triad), self.of(node.right, triad))
            case Call(name="lag", arguments=(_, Number(value=tau))):
                return self._lagged(self.lags.index(tau))
            case Call():
                arguments = ", ".join(self.of(each, triad) for each in node.arguments)
                return f"{self.functions.get(node.name, node.name)}({arguments})"

    def _name(self, name: str, triad: str) -> str:
        """Return an input; a vector's is the sensor's own component, another sensor's, or its length."""
        vector, _, part = name.partition("_")
        if name.startswith(AUXILIARY):
            return self._member(name)
        if vector in {"f", "omega", "B"}:
            return self._component(self._member("magnetic_ut") if vector == "B" else vector, part)
        if name == "out":
            return self._component("accel_out" if triad == "accelerometer" else "gyro_out", "")
        known = {"T": "warm", "T_rate": self._member("temperature_rate"), "warming": self._member("direction")}
        return name if name == "c" else known[name]

    @abstractmethod
    def number(self, value: float) -> str:
        """Return a constant with all its digits, in whatever unit it has, in parentheses where it is negative."""

    @abstractmethod
    def _member(self, name: str) -> str:
        """Return what the program's state holds."""

    @abstractmethod
    def _component(self, vector: str, part: str) -> str:
        """Return a vector's own component (no ``part``), one of another sensor, or its length."""

    @abstractmethod
    def _lagged(self, number: int) -> str:
        """Return a followed temperature [K] above 25 degC."""

    @abstractmethod
    def _operation(self, node: Operation, left: str, right: str) -> str:
        """Return two expressions joined."""


@dataclass(frozen=True, slots=True)
class CExpressions(Expressions):
    """C99 of `double`, or of `float`; a small whole power is multiplied out."""

    is_float: bool = False

    def number(self, value: float) -> str:
        """Return a constant of C, in whatever unit it has."""
        text = str(np.float32(value)) + "F" if self.is_float else repr(float(value))
        return f"({text})" if value < 0 else text

    def row(self, values: FloatArray) -> str:
        """Return ``values`` (n,), in whatever unit they have, as constants of an initialiser."""
        return ", ".join(self.number(float(each)) for each in values)

    def _member(self, name: str) -> str:
        return f"state->{name}"

    def _component(self, vector: str, part: str) -> str:
        if part == "norm":
            return f"length_of({vector})"
        if part in AXES and part:
            return f"{vector}[{AXES.index(part)}]"
        return f"{vector}[{f'(i + {int(part) - 1}) % 3' if part else 'i'}]"

    def _lagged(self, number: int) -> str:
        return f"behind[{number}]"

    def _operation(self, node: Operation, left: str, right: str) -> str:
        if node.sign != "**":
            return f"({left} {node.sign} {right})"
        match node.right:
            case Number(value=value) if value == int(value) and 0 <= value <= MAX_INTEGER_POWER:
                return f"power({left}, {int(value)})"
        return f"{self.functions['pow']}({left}, {right})"


@dataclass(frozen=True, slots=True)
class MatlabExpressions(Expressions):
    """MATLAB, columns of three sensors, joined element by element."""

    def number(self, value: float) -> str:
        """Return a constant of MATLAB, in whatever unit it has."""
        return f"({value!r})" if value < 0 else f"{value!r}"

    def _member(self, name: str) -> str:
        return f"state.{name}"

    def _component(self, vector: str, part: str) -> str:
        if part == "norm":
            return f"norm({vector})"
        if part in AXES and part:
            return f"{vector}({AXES.index(part) + 1})"
        return f"{vector}([{'2 3 1' if part == '2' else '3 1 2'}])" if part else vector

    def _lagged(self, number: int) -> str:
        return f"behind({number + 1})"

    def _operation(self, node: Operation, left: str, right: str) -> str:
        sign = {"*": ".*", "/": "./", "**": ".^"}.get(node.sign, node.sign)
        return f"({left} {sign} {right})"


def c_functions(is_float: bool) -> dict[str, str]:
    """Return the names in C of a term's functions."""
    end = "f" if is_float else ""
    same = {name: f"{name}{end}" for name in ("exp", "log", "tanh", "sqrt", "sin", "cos", "pow")}
    return {**same, "abs": f"fabs{end}", "min": f"fmin{end}", "max": f"fmax{end}", "sign": "sign_of"}
