"""The tables of parameters: value, expanded uncertainty U, 1 sigma, and for a simulated unit the truth.

Slab and faces have no budget: in the place of U stands the interval of 95 % that 1 sigma makes.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from procedures.calibration.solution_values import Estimate, Solution, TriadCalibration
from procedures.frames import AXES
from procedures.units import ARCSEC_PER_RAD, UG_PER_G
from station.text.rounding import aligned, decimals, fixed

NORMAL_95 = 1.959964  # two-sided 95 % of a normal distribution
_NONE: Mapping[str, float] = MappingProxyType({})
SYMBOLS = {"count/(g s)": "count/(g\u00b7s)"}


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number to print: its name in `Solution.names`, what it is called, value and 1 sigma in ``unit``.

    ``scale`` took it from the unit of files; ``noise_only`` marks a sigma that counting noise alone makes up.
    """

    name: str
    symbol: str
    axis: str
    value: float
    std: float
    unit: str
    scale: float = 1.0
    noise_only: bool = False


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """A printed line; ``expanded`` is U, empty without a budget; truth and errors are empty without a truth."""

    symbol: str
    axis: str
    value: str
    expanded: str
    std: str
    low: str
    high: str
    unit: str
    truth: str = ""
    error: str = ""
    sigmas: str = ""


@dataclass(frozen=True, slots=True)
class ParameterGroup:
    """Rows of one kind, with a remark under their heading."""

    title: str
    remark: str
    rows: tuple[ParameterRow, ...]


def triad_groups(
    name: str, triad: TriadCalibration, truth: Mapping[str, float], expanded: Mapping[str, float] = _NONE
) -> list[ParameterGroup]:
    """Return the parameter tables of a triad (``accelerometer`` or ``gyroscope``).

    ``expanded`` are the expanded uncertainties by parameter, in the unit of files.
    """
    groups = [
        _group("Scale factor k", "", _vector(f"{name}.scale_factor", "k", triad.scale_factor), truth, expanded),
        _group(
            "Misalignment E",
            "off-diagonal; first index sensor, second body axis",
            list(_off_diagonal(f"{name}.misalignment", triad.misalignment)),
            truth,
            expanded,
        ),
        _group("Bias D", "joint estimate: the one to use", _bias(name, triad.bias), truth, expanded),
    ]
    for title, estimate, equation in (
        ("Bias, 12-position mean", triad.bias_12_position, "eq. 8"),
        ("Bias, two-direction", triad.bias_two_direction, "eq. 9\u201311"),
    ):
        if estimate is not None:
            remark = f"Yao, Hu, He 2018, {equation}; its sigma is counting noise only"
            groups.append(_group(title, remark, _bias(name, estimate, noise_only=True), truth))
    return groups


def bench_groups(solution: Solution, truth: Mapping[str, float]) -> list[ParameterGroup]:
    """Return the tables of slab tilt and face parallelism, in arcsec."""
    groups = []
    if (tilt := solution.slab_tilt) is not None:
        quantities = [
            _angle(f"slab.tilt.{side}", "tilt", side, tilt.value[i], tilt.std[i])
            for i, side in enumerate(("east", "north"))
        ]
        remark = "components of the up vector seen from the slab"
        groups.append(_group("Slab tilt", remark, quantities, truth))
    if (faces := solution.parallelism) is not None:
        quantities = []
        for i, pair in enumerate(AXES):
            for j, other in enumerate(axis for axis in AXES if axis != pair):
                name = f"fixture.parallelism.{pair}.{other}"
                quantities.append(
                    _angle(name, f"pair {pair}", f"\u2192 {other}", faces.value[i, j], faces.std[i, j])
                )
        remark = "sum of the up tilts of the two faces of a pair, along the other axes"
        groups.append(_group("Face parallelism", remark, quantities, truth))
    return groups


def matrix_rows(misalignment: Estimate) -> list[list[str]]:
    """Return E (3, 3) with the uncertainty of its last digits in parentheses, dimensionless."""
    rows = []
    for value, std in zip(misalignment.value, misalignment.std, strict=True):
        cells = []
        for v, s in zip(value, std, strict=True):
            places = decimals(float(s))
            digits = f"({round(s * 10.0**places)})" if math.isfinite(s) and s > 0 else ""
            cells.append(fixed(float(v), max(places, 0)) + digits)
        rows.append(cells)
    return rows


def _vector(name: str, symbol: str, estimate: Estimate) -> list[Quantity]:
    unit = SYMBOLS.get(estimate.unit, estimate.unit)
    return [
        Quantity(f"{name}.{axis}", symbol, axis, float(estimate.value[i]), float(estimate.std[i]), unit)
        for i, axis in enumerate(AXES)
    ]


def _bias(name: str, estimate: Estimate, noise_only: bool = False) -> list[Quantity]:
    unit = estimate.unit
    scale, unit = (UG_PER_G, "\u00b5g") if unit == "g" else (1.0, SYMBOLS.get(unit, unit))
    return [
        Quantity(
            f"{name}.bias.{axis}",
            "D",
            axis,
            float(estimate.value[i]) * scale,
            float(estimate.std[i]) * scale,
            unit,
            scale,
            noise_only,
        )
        for i, axis in enumerate(AXES)
    ]


def _off_diagonal(name: str, estimate: Estimate) -> Iterator[Quantity]:
    for q, sensor in enumerate(AXES):
        for p, body in enumerate(AXES):
            if p != q:
                yield _angle(
                    f"{name}.{sensor}{body}", "E", f"{sensor}{body}", estimate.value[q, p], estimate.std[q, p]
                )


def _angle(name: str, symbol: str, axis: str, value: float, std: float) -> Quantity:
    value, std = float(value) * ARCSEC_PER_RAD, float(std) * ARCSEC_PER_RAD
    return Quantity(name, symbol, axis, value, std, "arcsec", ARCSEC_PER_RAD)


def _group(
    title: str, remark: str, quantities: Sequence[Quantity], truth: Mapping[str, float],
    expanded: Mapping[str, float] = _NONE,
) -> ParameterGroup:  # fmt: skip
    places = [decimals(q.std) for q in quantities]
    U = [expanded.get(q.name, math.nan) * q.scale for q in quantities]
    wide = [fixed(u, decimals(u)) if u > 0 else "" for u in U]

    def column(numbers: Sequence[float | None], sign: bool = False) -> list[str]:
        texts = ["" if n is None else fixed(n, p, sign) for n, p in zip(numbers, places, strict=True)]
        return aligned(texts) if any(texts) else texts

    known = [truth[q.name] * q.scale if q.name in truth else None for q in quantities]
    error = [None if t is None else q.value - t for q, t in zip(quantities, known, strict=True)]
    sigmas = [
        "" if e is None or q.noise_only or not q.std > 0 else fixed(e / q.std, 1, sign=True)
        for q, e in zip(quantities, error, strict=True)
    ]
    columns = (
        column([q.value for q in quantities]),
        aligned(wide) if any(wide) else wide,
        column([q.std for q in quantities]),
        column([q.value - NORMAL_95 * q.std for q in quantities]),
        column([q.value + NORMAL_95 * q.std for q in quantities]),
        [q.unit for q in quantities],
        column(known),
        column(error, sign=True),
        sigmas,
    )
    rows = [
        ParameterRow(q.symbol, q.axis, *cells)
        for q, cells in zip(quantities, zip(*columns, strict=True), strict=True)
    ]
    return ParameterGroup(title, remark, tuple(rows))
