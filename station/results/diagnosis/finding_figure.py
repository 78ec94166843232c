"""A finding's residual against the coordinate that reveals it: left without the error term, right with it.

Both are residuals of the whole model, fitted again: without the effect, its other parameters absorb as much of it
as they can, as they did before it was found.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.diagnosis.caches import clear_caches
from procedures.discovery.discover import Discovery, Proposal
from procedures.effects import CATALOGUE, EFFECTS
from procedures.effects.excitation import Excitation
from procedures.effects.term.functions import OPERATORS
from procedures.effects.term.grammar import calls, names
from procedures.effects.term.inputs import known_input
from procedures.effects.term.law import OUTPUT_UNITS, Law
from procedures.effects.term.units import parse_unit
from procedures.effects.term.values import Values
from procedures.evidence.candidates import Candidate, Candidates
from procedures.evidence.linear_model import Term
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import AXES, TRIADS
from procedures.inference.result import Diagnosis, Finding, FoldedResidual
from procedures.units import ARCSEC_PER_DEG, DEG_H_PER_DEG_S, S_PER_H, UG_PER_G
from station.results.diagnosis.diagnosis_json import plain
from station.results.diagnosis.finding_wording import where_text
from station.results.report.svg import AXIS_STYLE, INK, RULE, draw_svg

OUTPUTS = ("out", "out_changing")  # that a scale factor's term multiplies


@dataclass(frozen=True, slots=True, eq=False)
class Coordinate:
    """Values (n,) with a label; ``names`` where they only number steps."""

    label: str
    values: FloatArray
    names: tuple[str, ...] = ()


def coordinate_of(
    evidence: Evidence, finding: Finding, rows: BoolArray, added: FloatArray, unit: str
) -> Coordinate:
    """Return the coordinate of the rows (n,): what the effect's law depends on, its channel, or else the step.

    Where that differs between sensors, rows of all three (a rest's norm) have what the effect adds: ``added``
    (n,), in ``unit``.
    """
    effect, seen = CATALOGUE.get(finding.effect), evidence.excitation
    law = None if effect is None else effect.law(finding.shape)
    channel = str(finding.where.get("channel", ""))
    if law is not None:
        axis = law_axis(law, seen, finding.coefficients, finding.value, finding.std)
    elif channel in seen.auxiliary:
        axis = channel, np.tile(seen.auxiliary[channel][:, None], (1, len(AXES)))
    else:
        axis = None
    if axis is None or not np.isfinite(found := _at_rows(evidence, axis[1])[rows]).any():
        return _steps(evidence, rows)
    if np.any(evidence.axis[rows] < 0) and np.nanmax(np.ptp(axis[1], axis=1)) > 0:
        return Coordinate(f"what {finding.effect} adds [{unit}]", added[rows])
    return Coordinate(axis[0], found)


def law_axis(
    law: Law, seen: Excitation, coefficients: Sequence[str], value: FloatArray, std: FloatArray
) -> tuple[str, FloatArray] | None:
    """Return label and values (n, 3) of what each sensor's largest term depends on; None of the time in a step.

    That is its only input besides the output, or a lag of it, in its unit; of several inputs the term itself.
    ``value`` and ``std`` (k,) are the coefficients' in their units.
    """
    known = dict(zip(coefficients, value.tolist(), strict=True))
    size = {name: abs(known[name]) / s if s > 0 else 0.0 for name, s in zip(known, std.tolist(), strict=True)}
    largest = [0] * len(AXES) if law.is_polynomial else np.argmax(law.table(size), axis=1).tolist()
    parameters = {name: known[name] for name in law.parameters}
    columns = [_term_axis(law, seen, term, parameters) for term in largest]
    labels, values = [label for label, _ in columns], [each for _, each in columns]
    if "" in labels:
        return None
    shape = (len(seen.t), len(AXES))
    return "; ".join(dict.fromkeys(labels)), np.stack(
        [np.broadcast_to(each, shape)[:, sensor] for sensor, each in enumerate(values)], axis=1
    )


def _term_axis(law: Law, seen: Excitation, term: int, parameters: Mapping[str, float]) -> tuple[str, FloatArray]:
    """Return label and values, which broadcast to (n, 3), of what a term depends on; "" of the time in a step."""
    node, nothing = law.nodes()[term], np.full((1, 1), np.nan)
    inputs = {each.name for each in names(node)} & {*law.inputs} - {*OUTPUTS} or {"u"}
    if len(inputs) > 1:
        label = f"{law.terms[term]}, times {law.unit} [{OUTPUT_UNITS[law.triad]}]"
        return ("", nothing) if law.is_inside else (label, law.values(seen, parameters)[:, :, term])
    driving = known_input(inputs.pop(), law.triad)
    assert driving is not None
    if driving.driver == "time at rest":
        return "", nothing
    per, unit = (1 / S_PER_H, "h") if driving.unit == "s" else (1.0, driving.unit)
    if lag := next((each for each in calls(node) if each.name in OPERATORS), None):
        sizes = {name: parameters[name] * parse_unit(one.unit).size for name, one in law.parameters.items()}
        lagged = Values(seen, law.triad, sizes, in_bases=False).of(lag)
        return f"{driving.meaning}, lagged [{unit}]", per * lagged
    return f"{driving.meaning} [{unit}]", per * driving.value(seen, law.triad)


def _steps(evidence: Evidence, rows: BoolArray) -> Coordinate:
    """Return the step of each row; of a soak, whose blocks are no steps to a reader, the time."""
    numbers, index = np.unique(evidence.step[rows], return_inverse=True)
    steps = [evidence.excitation.steps[i] for i in numbers]
    if all(step.kind == "soak" for step in steps):
        return Coordinate("time [h]", means_at_rows(evidence, _hours(evidence.excitation))[rows])
    stems = [step.name.partition(".")[0] for step in steps]
    if all(step.kind == "rest" for step in steps) and len(set(stems)) < len(stems):  # of one recording
        return Coordinate("number of the rest", index + np.ones(len(index)))
    names = tuple(str(s.position) if s.kind == "dwell" else stem for s, stem in zip(steps, stems, strict=True))
    return Coordinate("position, turn or rest", index.astype(float), names)


def means_at_rows(evidence: Evidence, values: FloatArray) -> FloatArray:
    """Return the mean, in their unit, of values at the nodes (n, ...) that every row is seen at."""
    means = np.full((len(evidence.residual), *values.shape[1:]), np.nan)
    for each in evidence.weights:
        of_row = values[each.nodes]
        known = np.isfinite(of_row)
        count = np.sum(known, axis=0)
        total = np.sum(np.where(known, of_row, 0.0), axis=0)
        means[each.rows] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return means


def _hours(excitation: Excitation) -> FloatArray:
    found: FloatArray = (excitation.t - np.nanmin(excitation.t)) / S_PER_H
    return found


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
    """Rows (n,) of a triad and kind against ``coordinate``: residual ``before``, ``after``, u in ``unit``.

    ``axis`` (n,) is the sensor, -1 where a row is of all three. ``place`` says where its finding acts, in words.
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
    place: str = ""


@clear_caches()
def residual_panels(diagnosis: Diagnosis) -> list[ResidualPanel]:
    """Return a panel for every finding that can still be separated in the evidence."""
    ways = [_way(diagnosis, finding) for finding in diagnosis.findings]
    found = list[ResidualPanel]()
    for finding, way in zip(diagnosis.findings, ways, strict=True):
        if way is not None:
            others = [each.term for each in ways if each is not None and each is not way and not each.is_of_model]
            place = where_text({name: plain(what) for name, what in finding.where.items()})
            found.append(replace(panel_of(diagnosis.evidence, finding.effect, way, others, finding), place=place))
    return found


def folded_panels(diagnosis: Diagnosis) -> list[ResidualPanel]:
    """Return a panel for every finding in the samples: means by its phase, or by what it goes with."""
    found = dict[tuple[str, str, str], list[FoldedResidual]]()
    for each in diagnosis.folded:
        found.setdefault((each.effect, each.about, each.triad), []).append(each)
    return [_folded_panel(key[0], key[1], each) for key, each in found.items()]


def in_outputs(panel: ResidualPanel, unit: str) -> ResidualPanel:
    """Return a panel of a triad whose scale factor is not known in the ``unit`` of its outputs."""
    factor = {"deg/h": 1 / DEG_H_PER_DEG_S, "ug": 1 / UG_PER_G}.get(panel.unit, 1.0)
    sizes = {name: getattr(panel, name) * factor for name in ("before", "after", "sigma")}
    return replace(panel, unit=unit, **sizes)


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
    """Return the residual without and with an effect's columns, with others.

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


def proposed_panels(found: Discovery) -> list[ResidualPanel]:
    """Return a panel for every proposal, those before it in the model."""
    panels, others = list[ResidualPanel](), list(found.others)
    for one in found.proposals:
        panels.append(
            panel_of(found.evidence, _name(one), one.candidate, others, _coordinate(found.evidence, one))
        )
        others.append(one.columns[0])
    return panels


def _name(one: Proposal) -> str:
    return f"{one.term.triad}.{one.term.name}"


def _coordinate(evidence: Evidence, one: Proposal) -> Coordinate:
    axis = law_axis(one.term, evidence.excitation, one.coefficients, one.value, one.std)
    label, values = axis or ("time [h]", np.tile(_hours(evidence.excitation)[:, None], (1, len(AXES))))
    return Coordinate(label, _at_rows(evidence, values))


def _at_rows(evidence: Evidence, values: FloatArray) -> FloatArray:
    """Return the mean of each row's own sensor (n,) of values at the nodes (m, 3); of all where a row has none."""
    means, axis = means_at_rows(evidence, values), evidence.axis
    own: FloatArray = means[np.arange(len(axis)), np.maximum(axis, 0)]
    return np.where(axis < 0, means.mean(axis=1), own)


SIZE_IN = (7.0, 2.6)
_SPREAD = 0.2  # of a step, by which the three sensors stand apart
_ROWS = {"mean": "dwells", "turn": "turns", "move": "moves", "norm": "rests", "slope": "slopes within dwells",
         "curvature": "curvatures within dwells", "rate": "points of a rate table",
         "soak": "blocks of a soak", "samples": "means of samples"}  # fmt: skip


def residual_svg(number: int, panel: ResidualPanel) -> str:
    """Return the plot of a finding; ``number`` keeps it apart from others on the page."""
    text = f"Residual of the {panel.triad}, {_ROWS.get(panel.kind, panel.kind)}, without and with {panel.effect}"
    return draw_svg(f"finding-{number}", text, SIZE_IN, lambda figure: draw_panel(figure, panel))


def draw_panel(figure: Figure, panel: ResidualPanel) -> None:
    """Draw a finding's residual on an empty figure."""
    unit = panel.unit.replace("ug", "\u00b5g")
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, values, title in ((left, panel.before, "without it"), (right, panel.after, "with it")):
        _draw(axes, panel, values)
        axes.set_title(title, fontsize=8.5, color=INK, loc="left")
    left.set_ylabel(f"residual [{unit}]")
    handles, labels = left.get_legend_handles_labels()
    if len(labels) > 1:
        figure.legend(handles, labels, loc="outside upper right", ncols=3, handletextpad=0.1)
    figure.supxlabel(panel.coordinate.label, fontsize=8.5, color=INK)


def caption(panel: ResidualPanel) -> str:
    """Return what a plot shows."""
    noise = "a point's scatter" if panel.kind == "rate" else "counting noise"
    return f"{panel.triad.capitalize()}, {_ROWS.get(panel.kind, panel.kind)}; bars: 1\u03c3 of {noise}."


def _draw(axes: Axes, panel: ResidualPanel, values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    axes.axhline(0, color=RULE, linewidth=0.7, zorder=0)
    x = panel.coordinate.values
    for i in (-1, 0, 1, 2):
        rows = panel.axis == i
        if not rows.any():
            continue
        colour, marker = AXIS_STYLE[AXES[i]] if i >= 0 else (INK, "o")
        at = x[rows] + (_SPREAD * (i - 1) if panel.coordinate.names and i >= 0 else 0.0)
        axes.errorbar(
            at, values[rows], panel.sigma[rows], fmt=marker, color=colour, markersize=3.6, elinewidth=0.7,
            label=f"{panel.triad[0]}{AXES[i]}" if i >= 0 else "",
        )  # fmt: skip
    if panel.coordinate.names:
        axes.set_xticks(np.arange(len(panel.coordinate.names)), panel.coordinate.names)
        axes.tick_params(axis="x", labelsize=7 if len(panel.coordinate.names) < 14 else 5, length=0)
    elif np.array_equal(x, np.round(x)):  # whole numbers have no tick between them
        axes.locator_params(axis="x", integer=True)
