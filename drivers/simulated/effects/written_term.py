"""Effects written as `effect/1`, planted: read, parsed and worked out here, by nothing of what fits them.

Of the grammar (docs/how-to/own-effects.md) the inputs that a simulated unit knows of one moment are there, and the
lag of its temperature; `t_step` counts from when the cube was last moved. Python's parser makes a tree of the
term; every kind of node of it is looked at here, and none is ever run.
"""

import ast
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.errors import TruthRefused
from drivers.simulated.effects.planted_effect import (
    AXES,
    REFERENCE_C,
    Added,
    PlantedEffect,
    Stimulus,
    TriadInput,
)
from drivers.simulated.effects.sensors import sensor_temperature
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray

DEG = float(np.pi / 180)
SIZES = {  # of units, in g, rad, s, K and uT
    "g": 1.0, "mg": 1e-3, "ug": 1e-6, "rad": 1.0, "deg": DEG, "arcsec": DEG / 3600, "s": 1.0, "min": 60.0,
    "h": 3600.0, "Hz": 1.0, "K": 1.0, "uT": 1.0, "nT": 1e-3, "unit": 1.0, "ppm": 1e-6,
}  # fmt: skip
TRIED = 8  # moments that a term is worked out at before it is planted
ONE_MOMENT = (
    "what a simulated unit knows of one moment: u, out, f, omega, B (these three also with _2, _3, _x, _y, _z, "
    "_norm), T, T_rate, t, t_step, pi, a parameter, lag(T, tau)"
)
CALLS: dict[str, Callable[..., FloatArray]] = {
    "abs": np.abs, "sign": np.sign, "exp": np.exp, "log": np.log, "tanh": np.tanh, "sqrt": np.sqrt,
    "sin": np.sin, "cos": np.cos, "min": np.minimum, "max": np.maximum,
}  # fmt: skip
SIGNS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b, ast.Sub: lambda a, b: a - b, ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b, ast.Pow: lambda a, b: a**b,
}  # fmt: skip


def _moments() -> Stimulus:
    """Return moments that differ in everything, to try a term on."""
    one = np.linspace(-60.0, 60.0, TRIED)[:, None]
    vector, t = np.hstack((one, one / 2, -one)), np.linspace(1.0, 3600.0, TRIED)[:, None]
    return Stimulus(vector, vector, vector, t, t, REFERENCE_C + one, one, 1, np.ones_like)


def planted_term(name: str, text: str) -> PlantedEffect:
    """Return the effect of an `effect/1` as it can be planted: its coefficients, its parameters as options.

    Raises
    ------
    TruthRefused
        If the text is none, is of another name, or says what cannot be planted.
    """
    try:
        table = tomllib.loads(text)
        triad, own = str(table["triad"]), f"{table['triad']}.{table['name']}"
        terms = [table["term"]] if isinstance(table["term"], str) else list(table["term"])
        shape = {key: (_size(one["unit"]), float(one["low"] * one["high"]) ** 0.5)
                 for key, one in table.get("shape", {}).items()}  # fmt: skip
        nodes, unit = [_parsed(term) for term in terms], str(table["unit"])
        per = _size(unit) / {"accelerometer": 1.0, "gyroscope": DEG}[triad]
    except (tomllib.TOMLDecodeError, KeyError, TypeError, ValueError, ArithmeticError) as error:
        raise TruthRefused(f"terms.{name}: {error!r}", "the text of an effect/1") from error
    if own != name:
        raise TruthRefused(f"terms.{name} of {own}", f"that of {name}")
    names = tuple(AXES) if len(nodes) == 1 else tuple(f"{a}.{i + 1}" for a in AXES for i in range(len(nodes)))

    def summed(seen: Stimulus, of: TriadInput, sizes: Sizes) -> FloatArray:
        term = _Term(seen, of, triad, {key: sizes[key] * size for key, (size, _) in shape.items()})
        c = np.array([[sizes.get(names[i * len(nodes) + j], 0.0) for i in range(3)] for j in range(len(nodes))])
        with np.errstate(all="ignore"):  # what is not finite is refused
            columns = [np.atleast_2d(term.value(node)) for node in nodes]
            parts = (np.where(c[j] == 0, 0.0, per * c[j] * column) for j, column in enumerate(columns))
            total: FloatArray = sum(parts, np.zeros((1, 3)))
        return total

    def added(seen: Stimulus, of: TriadInput, sizes: Sizes) -> FloatArray:
        if not np.isfinite(total := summed(seen, of, sizes)).all():
            at = f"{np.ravel(seen.t)[0]:g} s, {np.ravel(seen.temperature)[0]:.4g} degC"
            raise TruthRefused(f"{name} not finite at {at}", "a term that is finite in all that the unit meets")
        return total

    one, middles = {triad: added}, {key: middle for key, (_, middle) in shape.items()}
    _try(name, summed, dict.fromkeys(names, 1.0) | middles)
    return PlantedEffect(
        name, unit, names, middles,
        accel=one.get("accelerometer"), gyro=one.get("gyroscope"),
    )  # fmt: skip


def _try(name: str, summed: Added, sizes: Sizes) -> None:
    """Refuse at once what cannot be planted: what no moment determines, or what is finite at none."""
    try:
        found = np.asarray(summed(_moments(), TriadInput(_moments().f, np.ones(3)), sizes))
    except TruthRefused:
        raise
    except (ArithmeticError, TypeError, ValueError) as error:
        raise TruthRefused(f"terms.{name}: {error}", "a term of finite numbers") from error
    if not np.isrealobj(found) or not np.isfinite(found).any():
        raise TruthRefused(f"terms.{name} that is finite nowhere", "a term of finite numbers")


def _parsed(text: str) -> ast.expr:
    """Return a term or a unit as a tree; ``^`` is a power, a middle dot a product."""
    try:
        return ast.parse(text.strip().replace("^", "**").replace("\u00b7", "*"), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"no term: {text[:60]!r}") from None


def _size(unit: str) -> float:
    """Return the size of a unit in g, rad, s, K and uT."""
    if not 0 < (size := float(_number(_parsed(unit)))) < np.inf:
        raise ValueError(f"a unit of size {size:g}: {unit[:60]!r}")
    return size


def _number(node: ast.expr) -> float:
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.Name(id=name) if name in SIZES:
            return SIZES[name]
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            return -_number(inner)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in SIGNS:
            return float(SIGNS[type(operator)](_number(left), _number(right)))
    raise ValueError(f"no unit: {ast.unparse(node)[:60]}")


@dataclass(frozen=True, slots=True, eq=False)
class _Term:
    """What a term is at the samples; ``shape`` holds its parameters in g, rad, s, K and uT."""

    seen: Stimulus
    of: TriadInput
    triad: str
    shape: Mapping[str, float]

    def value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=int() | float() as value):
                return float(value)
            case ast.Subscript(value=ast.Constant(value=int() | float() as value), slice=unit):
                return value * _number(unit)
            case ast.Name(id=name):
                return self.named(name)
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return -self.value(inner)
            case ast.BinOp(left=left, op=operator, right=right) if type(operator) in SIGNS:
                return SIGNS[type(operator)](self.value(left), self.value(right))
            case ast.Call(func=ast.Name(id="lag"), args=[ast.Name(id="T"), time], keywords=[]):
                return sensor_temperature(self.seen, float(self.value(time)))[:, None] - REFERENCE_C
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in CALLS:
                return CALLS[name](*map(self.value, arguments))
        raise TruthRefused(f"{ast.unparse(node)[:60]} in a term", ONE_MOMENT)

    def named(self, name: str) -> Any:
        """Return a parameter, a constant or an input."""
        if name in self.shape:
            return self.shape[name]
        seen, is_gyro = self.seen, self.triad == "gyroscope"
        known: dict[str, Callable[[], Any]] = {
            "pi": lambda: np.pi, "t": lambda: seen.t, "t_step": lambda: seen.rest_s,
            "T": lambda: seen.temperature - REFERENCE_C, "T_rate": lambda: seen.temperature_rate / 60,
            "u": lambda: DEG * seen.omega if is_gyro else seen.f,
            "out": lambda: (DEG if is_gyro else 1.0) * (self.of.raw + self.of.bias),
        }  # fmt: skip
        if name in known:
            return known[name]()
        vector, _, which = name.partition("_")
        vectors = {"f": seen.f, "omega": DEG * seen.omega, "B": seen.magnetic}
        along = {"": [0, 1, 2], "2": [1, 2, 0], "3": [2, 0, 1], "x": [0], "y": [1], "z": [2]}
        if vector in vectors and which in along:
            return vectors[vector][:, along[which]]
        if vector in vectors and which == "norm":
            return np.sqrt(np.sum(vectors[vector] ** 2, axis=1))[:, None]
        raise TruthRefused(f"{name} in a term", ONE_MOMENT)
