"""What is left out in turn, and the residual's rms before and after the effects, there and in the campaign.

Left out are every position of a campaign with all its repeats, every turn, move and rest, and everything that was
stated: each face's certificate, gravity, headings and closures are predicted by the rest like a measurement.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.evidence.linear_model import LinearFit, fit_linear, predict_left_out
from procedures.evidence.refit import Refit
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import TRIADS
from procedures.inference.result import ResidualRms
from procedures.units import DEG_H_PER_DEG_S

SHOWN = (
    ("mean", "dwells", "g", 1.0, "deg/h", DEG_H_PER_DEG_S),
    ("turn", "turns", "", 0.0, "deg", 1.0),
    ("move", "moves", "", 0.0, "deg", 1.0),
    ("norm", "rests", "g", 1.0, "", 0.0),
    ("soak", "soaks", "g", 1.0, "deg/h", DEG_H_PER_DEG_S),
    ("level", "neighbouring soaks", "g", 1.0, "deg/h", DEG_H_PER_DEG_S),
    ("rate", "rate points", "", 0.0, "deg/s", 1.0),
)
LEFT_OUT_S = 100.0  # of a soak at a time: what its neighbours foretell of less says little


def left_out_groups(evidence: Evidence) -> list[IntArray]:
    """Return the row numbers (r,), dimensionless, of each position, turn, move, rest, soak's level and statement.

    Shorter blocks of a soak are left out together, as many as `LEFT_OUT_S` has.
    """
    keys, together = dict[tuple[object, ...], list[int]](), _blocks_together(evidence)
    for row, number in enumerate(evidence.step.tolist()):
        if evidence.kind[row] == KINDS.index("level"):
            keys.setdefault(("level", number), []).append(row)
        elif number >= 0:
            step = evidence.excitation.steps[number]
            name = together.get(number, step.position if step.kind == "dwell" else step.name)
            keys.setdefault((step.campaign, step.kind, name), []).append(row)
        elif not evidence.is_range[row]:
            keys[row,] = [row]
    return [np.array(rows) for rows in keys.values()]


def _blocks_together(evidence: Evidence) -> dict[int, str | int]:
    """Return by the number of each short block of a soak the name of those left out with it."""
    seen, of_soak = evidence.excitation, dict[tuple[int, str], dict[str, list[int]]]()
    for number, step in enumerate(seen.steps):
        if step.kind == "soak":
            soak = of_soak.setdefault((step.campaign, step.name.rpartition(" ")[0]), {})
            soak.setdefault(step.name, []).append(number)
    found = dict[int, str | int]()
    for soak in of_soak.values():
        first, last = (float(seen.t[seen.step == list(soak.values())[i][0]].mean()) for i in (0, -1))
        several = int(LEFT_OUT_S * max(len(soak) - 1, 1) / (last - first)) if last > first else 1
        names = list(soak)
        if several > 1:
            found |= {n: names[i // several * several] for i, name in enumerate(names) for n in soak[name]}
    return found


def residual_rms(before: Evidence, after: Refit, left_out: Sequence[IntArray]) -> tuple[ResidualRms, ...]:
    """Return the errors of dwells, turns, moves and rests of each triad [g, deg/h, deg, deg/s].

    ``left_out`` are the row numbers (r,) of each group to leave out.
    """
    return errors_of_fits(before, after.evidence, fit_linear(before, []), after.linear, left_out)


def errors_of_fits(
    before: Evidence, after: Evidence, first: LinearFit, last: LinearFit, left_out: Sequence[IntArray],
    acts: BoolArray | None = None,
) -> tuple[ResidualRms, ...]:  # fmt: skip
    """Return the errors of dwells, turns, moves and rests [g, deg/h, deg, deg/s] of two fits of the same rows.

    ``left_out`` are the row numbers (r,) of each group to leave out, ``acts`` (n,) the rows to look at, else all.
    """
    parts = [_natural(before, first, left_out), _natural(after, last, left_out)]
    found = list[ResidualRms]()
    for kind, steps, unit_a, per_a, unit_g, per_g in SHOWN:
        for triad, unit, per in zip(TRIADS, (unit_a, unit_g), (per_a, per_g), strict=True):
            rows = before.rows(kind, triad=triad)
            rows = rows if acts is None else rows & acts[: len(rows)]
            if rows.any() and per:
                values = [_rms(each[rows]) for part in parts for each in part]
                b, hb, a, ha = (None if v is None else v * per for v in values)
                found.append(ResidualRms(f"{triad} {steps}", unit, b or 0.0, a or 0.0, hb, ha))
    return tuple(found)


def _natural(evidence: Evidence, fit: LinearFit, left_out: Sequence[IntArray]) -> tuple[FloatArray, FloatArray]:
    """Return the residual (n,) and the error where left out (n,), in natural units."""
    sigma = evidence.sigma * fit.factor
    return fit.white * sigma, predict_left_out(evidence, fit, left_out)[1] * sigma


def _rms(values: FloatArray) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else None
