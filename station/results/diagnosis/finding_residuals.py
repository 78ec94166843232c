"""The residual of the rows that gave an effect away, without it and with it in the model.

Both are residuals of the whole model, fitted again: without the effect its parameters absorb of it what they can,
as they did before it was found.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.diagnosis.caches import let_go_at_the_end
from procedures.effects import EFFECTS
from procedures.evidence.candidates import Candidate, Candidates
from procedures.evidence.linear_model import Term
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import TRIADS
from procedures.inference.result import Diagnosis, Finding, FoldedResidual
from procedures.units import ARCSEC_PER_DEG, DEG_H_PER_DEG_S, UG_PER_G
from station.results.diagnosis.plot_coordinates import Coordinate, coordinate_of

_UNITS = {  # of a row in natural units to people's, by triad and kind
    ("accelerometer", "mean"): (UG_PER_G, "ug"),
    ("accelerometer", "norm"): (UG_PER_G, "ug"),
    ("accelerometer", "slope"): (3.6e9, "ug/h"),
    ("accelerometer", "curvature"): (1.296e13, "ug/h^2"),
    ("gyroscope", "mean"): (DEG_H_PER_DEG_S, "deg/h"),
    ("accelerometer", "soak"): (UG_PER_G, "ug"),
    ("gyroscope", "turn"): (ARCSEC_PER_DEG, "arcsec"),
    ("gyroscope", "move"): (ARCSEC_PER_DEG, "arcsec"),
    ("gyroscope", "rate"): (1.0, "deg/s"),
    ("gyroscope", "soak"): (DEG_H_PER_DEG_S, "deg/h"),
    ("gyroscope", "slope"): (1.296e7, "deg/h per h"),
    ("gyroscope", "curvature"): (4.6656e10, "deg/h per h^2"),
}


@dataclass(frozen=True, slots=True, eq=False)
class ResidualPanel:
    """Rows (n,) of a triad and kind against ``coordinate``: residual ``before``, ``after``, 1 sigma in ``unit``.

    ``axis`` (n,) is the sensor, -1 where a row is of all three.
    """

    effect: str
    triad: str
    kind: str
    unit: str
    coordinate: Coordinate
    axis: IntArray
    before: FloatArray
    after: FloatArray
    sigma: FloatArray


@let_go_at_the_end()
def residual_panels(diagnosis: Diagnosis) -> list[ResidualPanel]:
    """Return a panel for every finding that still can be told apart in the evidence."""
    ways = [_way(diagnosis, finding) for finding in diagnosis.findings]
    found = list[ResidualPanel]()
    for finding, way in zip(diagnosis.findings, ways, strict=True):
        if way is not None:
            others = [each.term for each in ways if each is not None and each is not way and not each.is_of_model]
            found.append(panel_of(diagnosis.evidence, finding.effect, way, others, finding))
    return found


def folded_panels(diagnosis: Diagnosis) -> list[ResidualPanel]:
    """Return a panel for every finding in the samples: means by its phase, or by what it goes with."""
    found = dict[tuple[str, str, str], list[FoldedResidual]]()
    for each in diagnosis.folded:
        found.setdefault((each.effect, each.about, each.triad), []).append(each)
    return [_folded_panel(key[0], key[1], each) for key, each in found.items()]


def _folded_panel(effect: str, about: str, folded: Sequence[FoldedResidual]) -> ResidualPanel:
    first = folded[0]
    phase, before, after, sigma = (
        np.concatenate([getattr(each, name) for each in folded]) for name in ("phase", "before", "after", "sigma")
    )
    axis = np.repeat([each.axis for each in folded], len(first.phase))
    where = Coordinate(first.coordinate or f"phase of {about} [turns]", phase)
    return ResidualPanel(effect, first.triad, "samples", first.unit, where, axis, before, after, sigma)


def _way(diagnosis: Diagnosis, finding: Finding) -> Candidate | None:
    """Return the columns by which a finding acts; None of what a table showed, where the evidence is a bench's."""
    tables = {table.name for each in diagnosis.after.campaigns for table in each.rate_tables}
    if _first(finding.where.get("file")) in tables and not diagnosis.evidence.rows("rate").any():
        return None
    fitted = (each for each in diagnosis.added if each.effect.at and each.effect.name == finding.effect)
    if (own := next(fitted, None)) is not None:
        return own  # at the time constant and orders that were found
    effect = [each for each in EFFECTS if each.name == finding.effect]
    ways = Candidates(diagnosis.evidence, diagnosis.after, effect).get(finding.effect, [])
    same = [way for way in ways if way.columns.shape == finding.shape and _is_there(way, finding)]
    return next(iter(same or ways), None)


def _is_there(way: Candidate, finding: Finding) -> bool:
    """Say whether a way is about the same position or file; a finding may name several, its own first."""
    return all(_first(finding.where.get(name)) == _first(value) for name, value in way.columns.where.items())


def _first(value: object) -> object:
    return value[0] if isinstance(value, Sequence) and not isinstance(value, str) else value


def panel_of(
    evidence: Evidence, effect: str, way: Candidate, others: Sequence[Term], coordinate: Finding | Coordinate
) -> ResidualPanel:
    """Return the residual without and with an effect's columns, beside others.

    ``coordinate`` is of all rows, or of the rows in which it shows most the finding's own.
    """
    with_it = way.fit(evidence, others)
    without = way.without(evidence, others, with_it.factor)
    c, _ = with_it.coefficients()
    added = way.term.H @ c
    rows = _telling(evidence, added / evidence.sigma)
    triad, kind = TRIADS[evidence.triad[rows][0]], KINDS[evidence.kind[rows][0]]
    scale, unit = _UNITS.get((triad, kind), (1.0, ""))
    natural = scale * evidence.sigma * with_it.factor
    if isinstance(coordinate, Finding):
        where = coordinate_of(evidence, coordinate, rows, added * scale, unit)
    else:
        where = Coordinate(coordinate.label, coordinate.values[rows])
    return ResidualPanel(
        effect, triad, kind, unit, where, evidence.axis[rows],
        (without.white * natural)[rows], (with_it.white * natural)[rows], (scale * evidence.sigma)[rows],
    )  # fmt: skip


def _telling(evidence: Evidence, sigmas: FloatArray) -> BoolArray:
    """Mark the rows of the triad and kind in which an effect shows most; it moves them by ``sigmas`` (n,)."""
    strength: Mapping[tuple[int, int], float] = {
        (triad, kind): float(np.sum(sigmas[(evidence.triad == triad) & (evidence.kind == kind)] ** 2))
        for triad, kind in sorted({*zip(evidence.triad.tolist(), evidence.kind.tolist(), strict=True)})
        if KINDS[kind] != "prior"
    }
    triad, kind = max(strength, key=lambda key: strength[key])
    rows: BoolArray = (evidence.triad == triad) & (evidence.kind == kind)
    return rows
