"""The parameters of a `solution/1` or `calibration/1` document one by one, by name, and as people read them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import reduce
from math import hypot
from operator import getitem
from typing import Any

from procedures.frames import AXES, TRIADS
from procedures.units import ARCSEC_PER_RAD, UG_PER_G
from station.results.result_formats import IS_KEY
from station.text import decimals

APPLIED = ("scale_factor", "misalignment", "bias")  # what a calibration/1 holds of a triad
_DISPLAY_UNITS = {"g": (UG_PER_G, "ug"), "rad": (ARCSEC_PER_RAD, "arcsec")}
_PRINTED_UNITS = {"ug": "\u00b5g", "count/(g s)": "count/(g\u00b7s)"}
_SMALL_ANGLES = ("misalignment",)  # dimensionless in files, small angles to people


@dataclass(frozen=True, slots=True)
class ParameterKind:
    """A kind of a triad's parameters: its field in files, symbol, name, how it was estimated, a remark."""

    field: str
    symbol: str
    name: str
    method: str = ""
    remark: str = ""

    @property
    def heading(self) -> str:
        """Name and symbol, as a table has them."""
        return f"{self.name.capitalize()} {self.symbol}{self.method}"


_TEXTBOOK = "for comparison, Yao, Hu, He 2018, {}; its u includes counting noise only"
KINDS = (
    ParameterKind("scale_factor", "K", "scale factor"),
    ParameterKind(
        "misalignment", "E", "misalignment", "",
        "off-diagonal, as an angle; first index sensor, second body axis",
    ),
    ParameterKind("bias", "D", "bias"),
    ParameterKind("bias_12_position", "D", "bias", ", 12 positions", _TEXTBOOK.format("eq. 8")),
    ParameterKind("bias_two_direction", "D", "bias", ", two directions", _TEXTBOOK.format("eq. 9\u201311")),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Parameter:
    """A value and its standard uncertainty (None where it has none) in ``unit``, both as in the document."""

    name: str = field(metadata=IS_KEY)
    value: float
    std: float | None
    unit: str

    @property
    def title(self) -> str:
        """The parameter in words: ``accelerometer bias z``."""
        return title_of(self.name)


def title_of(name: str) -> str:
    """Return a parameter's name in words."""
    return name.replace("_rms_g", " rms").replace("_rms_deg_h", " rms").replace("_", " ").replace(".", " ")


def parameters(document: Mapping[str, Any]) -> dict[str, Parameter]:
    """Return all parameters of a document by name, in its order; what it leaves out is not there."""
    return {one.name: one for one in (*_estimates(document), *_residual(document))}


def applied(found: Mapping[str, Parameter]) -> dict[str, Parameter]:
    """Return those that a calibration applies: scale factors, misalignments and biases of both triads."""
    return {
        name: one for name, one in found.items() if name.split(".")[0] in TRIADS and name.split(".")[1] in APPLIED
    }


def shown_scale(name: str, unit: str) -> tuple[float, str]:
    """Return by what a value is multiplied for people, and the unit it then has."""
    if name.split(".")[1] in _SMALL_ANGLES:
        return _DISPLAY_UNITS["rad"]
    return _DISPLAY_UNITS.get(unit, (1.0, unit if unit != "1" else ""))


def printed_scale(name: str, unit: str) -> tuple[float, str]:
    """Return the same, the unit with the signs that a terminal may lack."""
    scale, text = shown_scale(name, unit)
    return scale, _PRINTED_UNITS.get(text, text)


def shown(parameter: Parameter, value: float | None = None) -> tuple[str, str]:
    """Return a number of a parameter's kind, its own if none is given, as people read it, and the unit.

    It has the decimals that show two digits of the parameter's sigma.
    """
    scale, unit = shown_scale(parameter.name, parameter.unit)
    number = (parameter.value if value is None else value) * scale
    if parameter.std is None:
        return f"{number:z.3g}", unit
    return f"{number:z.{min(max(decimals(parameter.std * scale), 0), 7)}f}", unit


def shown_sigma(parameter: Parameter) -> str:
    """Return a parameter's sigma as people read it, empty if it has none."""
    return "" if parameter.std is None else shown(parameter, parameter.std)[0]


def shown_shift(change: Parameter) -> str:
    """Return a change with its sign, +- its sigma if it has one, and its unit."""
    text, unit = shown(change)
    std = "" if change.std is None else f" +- {shown_sigma(change)}"
    return f"{text if text.startswith('-') else '+' + text}{std} {unit}"


@dataclass(frozen=True, slots=True)
class ParameterShift:
    """By how much a parameter changed between two calibrations, and that over their combined uncertainty u."""

    parameter: Parameter
    shift: float
    sigmas: float

    def __str__(self) -> str:
        text, unit = shown(self.parameter, self.shift)
        return f"{text if text.startswith('-') else '+' + text} {unit} ({abs(self.sigmas):.1f} u)"


def combined_sigma(now: Parameter, before: Parameter) -> float:
    """Return the standard uncertainty of the difference of two whose errors are independent, 0 if one has none."""
    return 0.0 if now.std is None or before.std is None else hypot(now.std, before.std)


def shifts(
    now: Mapping[str, Parameter],
    before: Mapping[str, Parameter],
    sigma: Callable[[Parameter, Parameter], float] = combined_sigma,
) -> dict[str, ParameterShift]:
    """Return the shift of every parameter that both documents hold in one unit, if its ``sigma`` is not 0."""
    found = dict[str, ParameterShift]()
    for name, one in now.items():
        old = before.get(name)
        if old is not None and old.unit == one.unit and (std := sigma(one, old)) > 0:
            found[name] = ParameterShift(one, one.value - old.value, (one.value - old.value) / std)
    return found


def largest(found: Mapping[str, ParameterShift]) -> ParameterShift | None:
    """Return the shift of most sigmas."""
    return max(found.values(), key=lambda one: abs(one.sigmas), default=None)


_SENSORS = {axis: (i,) for i, axis in enumerate(AXES)}
_PAIRS = {sensor + body: (q, p) for q, sensor in enumerate(AXES) for p, body in enumerate(AXES) if p != q}
_FACES = {f"{a}.{b}": (i, j) for i, a in enumerate(AXES) for j, b in enumerate(axis for axis in AXES if axis != a)}
_ESTIMATES = (  # part and field of a document, what its parameters' names begin with, and where each value stands
    *(
        (triad, field, f"{triad}.{field}", _PAIRS if field == "misalignment" else _SENSORS)
        for triad in TRIADS
        for field in (*APPLIED, "bias_12_position", "bias_two_direction")
    ),
    ("slab", "tilt_rad", "slab.tilt", {"east": (0,), "north": (1,)}),
    ("fixture", "parallelism_rad", "fixture.parallelism", _FACES),
)


def _estimates(document: Mapping[str, Any]) -> Iterator[Parameter]:
    for part, estimate, name, places in _ESTIMATES:
        if found := document.get(part, {}).get(estimate):
            for end, place in places.items():
                value, std = (reduce(getitem, place, found[key]) for key in ("value", "std"))
                yield Parameter(f"{name}.{end}", value, std, found["unit"])


def _residual(document: Mapping[str, Any]) -> Iterator[Parameter]:
    found = document.get("residual", {})
    for key, unit in (("accelerometer_rms_g", "g"), ("gyroscope_rms_deg_h", "deg/h"), ("p_value", "1")):
        if key in found:
            yield Parameter(f"residual.{key}", found[key], None, unit)
