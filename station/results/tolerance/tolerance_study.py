"""All that is asked of one cube's tolerances, computed once for table, figure and file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import ITEMS, p1_tilts
from procedures.tolerance.estimator_errors import (
    ESTIMATOR_NAMES,
    Directions,
    DrawnErrors,
    EstimatorErrors,
    ToleranceShape,
    ToleranceUnit,
    draw_errors,
    estimator_errors,
)
from procedures.tolerance.improvements import RemedyGain, remedies, remedy_gain
from procedures.tolerance.neglected_effects import SET_ASIDE, SetAsideCase, combined, set_aside_errors
from procedures.tolerance.tolerances_for_accuracy import (
    AllowedTolerance,
    Quantity,
    all_errors,
    allowed_tolerances,
    worst_case,
    worst_corner,
)
from procedures.units import RAD_PER_DEG
from station.results.tolerance.tolerance_inputs import Drawing

FORMAT = "tolerance/1"
ESTIMATORS = dict(zip(ESTIMATOR_NAMES, ("12-position", "two-direction", "joint"), strict=True))
SEED = 1  # equal calls give equal numbers


@dataclass(frozen=True, slots=True)
class ToleranceQuestion:
    """Cubes to draw, and how; the accuracy wanted [g] of which estimator; certificate [rad], noise [g]."""

    cubes: int
    shape: ToleranceShape
    directions: Directions
    estimator: str
    wanted: float | None
    certificate: float
    noise: float


@dataclass(frozen=True, slots=True, eq=False)
class ToleranceStudy:
    """The answers.

    ``p1``: errors with every item at its limit in the directions of Yao 2018 table 3, one cube. ``worst`` (21,)
    and ``reached`` (21,): rows of `all_errors`. ``allowed`` is None where no accuracy was asked for.
    ``set_aside``: 1 sigma (3,) by item and quantity of what Yao 2018 sets aside.
    """

    drawing: Drawing
    question: ToleranceQuestion
    p1: EstimatorErrors
    worst: FloatArray
    reached: FloatArray
    sample: DrawnErrors
    allowed: list[AllowedTolerance] | None
    gains: list[RemedyGain]
    set_aside: Mapping[str, Mapping[str, FloatArray]]


def study(drawing: Drawing, unit: ToleranceUnit, question: ToleranceQuestion) -> ToleranceStudy:
    """Answer all questions about a cube; raise `AccuracyUnreachable` if no cube gives the accuracy wanted."""
    allowed = None
    if question.wanted is not None:
        asked = worst_case(_bias(unit, ESTIMATOR_NAMES.index(question.estimator)))
        allowed = allowed_tolerances(asked, question.wanted, drawing.item, drawing.weight)
    quantity = all_errors(unit)
    return ToleranceStudy(
        drawing,
        question,
        estimator_errors(p1_tilts(drawing.item)[..., None], unit),
        worst_case(quantity).largest(drawing.item),
        worst_corner(quantity, drawing.item),
        draw_errors(drawing.item, unit, question.cubes, SEED, question.shape, question.directions),
        allowed,
        [
            remedy_gain(each, drawing.item, unit, question.noise, shape=question.shape)
            for each in remedies(question.certificate)
        ],
        set_aside_errors(drawing.set_aside, _case(drawing, unit)),
    )


def _case(drawing: Drawing, unit: ToleranceUnit) -> SetAsideCase:
    told = drawing.campaign
    seat = told.seat_side_mm or drawing.side_mm / 2
    return SetAsideCase(unit.E, drawing.side_mm, seat, told.latitude_deg * RAD_PER_DEG, told.turn_s, drawing.item)


def _bias(unit: ToleranceUnit, estimator: int) -> Quantity:
    return lambda tilts: estimator_errors(tilts, unit).bias[estimator]


def document(found: ToleranceStudy) -> dict[str, Any]:
    """Return ``tolerance/1``: biases [g], scale factor relative, angles [rad], tolerances [mm]."""
    side, sample = found.drawing.side_mm, found.sample
    items = dict(zip(ITEMS, (found.drawing.item * side).tolist(), strict=True))
    parts: dict[str, Any] = {"format": FORMAT, "cube": found.drawing.cube, "side_mm": side, "tolerance_mm": items}
    parts["cubes_drawn"] = found.question.cubes
    parts["distribution"] = {"items": found.question.shape, "directions": found.question.directions}
    parts["bias"] = {
        name: {
            "unit": "g",
            "p1_case": found.p1.bias[i, :, 0].tolist(),
            "worst_case_at_most": found.worst[3 * i : 3 * i + 3].tolist(),
            "worst_case_reached": found.reached[3 * i : 3 * i + 3].tolist(),
            **_spread(sample.bias[i]),
        }
        for i, name in enumerate(ESTIMATOR_NAMES)
    }
    parts["scale_factor"] = {"unit": "1", "worst_case_at_most": found.worst[9:12].tolist()}
    parts["scale_factor"] |= _spread(sample.scale_factor)
    parts["misalignment"] = {"unit": "rad"} | _spread(sample.misalignment)
    if found.allowed is not None:
        parts["wanted"] = {"estimator": found.question.estimator, "bias_g": found.question.wanted}
        parts["allowed"] = [_allowed(one, side) for one in found.allowed]
    parts["would_buy"] = [
        {"with": one.help.name, "bias_std_g": one.bias, "bias_std_k2_open_g": one.bias_open,
         "k2_std_g_per_g2": one.K2, "misalignment_std_rad": one.misalignment}
        for one in found.gains
    ]  # fmt: skip
    parts["set_aside"] = [_set_aside(name, found.drawing.set_aside[name], errors)
                          for name, errors in found.set_aside.items()]  # fmt: skip
    together = combined(found.set_aside)
    parts["set_aside_together"] = {name: sigma.tolist() for name, sigma in together.items()}
    return parts


def _set_aside(name: str, size: float, errors: Mapping[str, FloatArray]) -> dict[str, Any]:
    item = SET_ASIDE[name]
    told = {"item": name, "what": item.what, "size": size, "unit": item.unit, "source": item.source}
    return told | {"std": {quantity: sigma.tolist() for quantity, sigma in errors.items()}}


def _spread(values: FloatArray) -> dict[str, list[float]]:
    """Return root mean square and 95 % quantile of the magnitude (3,) of errors (3, n)."""
    return {
        "rms": np.sqrt(np.mean(values**2, axis=1)).tolist(),
        "within_95_percent": np.quantile(np.abs(values), 0.95, axis=1).tolist(),
    }


def _allowed(one: AllowedTolerance, side_mm: float) -> dict[str, Any]:
    alone = None if one.alone is None else one.alone * side_mm
    sizes = {"present_mm": one.present * side_mm, "allowed_mm": one.allowed * side_mm, "alone_mm": alone}
    return {"item": one.item, **sizes, "change": one.change, "saving": one.saving}
