"""The residual of a proposed term against what gives it away: its one input, else the term itself."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.discovery.discover import Discovery, Proposal
from procedures.effects.term.effect_of_term import OUTPUT_UNITS
from procedures.effects.term.inputs import input_of
from procedures.evidence.residual_rows import Evidence
from procedures.frames import AXES
from station.results.diagnosis.finding_residuals import ResidualPanel, panel_of
from station.results.diagnosis.plot_coordinates import Coordinate, means_at_rows


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
    seen, triad = evidence.excitation, one.term.triad
    if len(one.term.inputs) == 1 and (known := input_of(one.term.inputs[0], triad)) is not None:
        value = known.value(seen, triad)
        label = f"{known.meaning} [{known.unit}]"
    else:
        values = dict(zip(one.coefficients, one.value.tolist(), strict=True))
        value = one.term.values(seen, {name: values[name] for name in one.term.parameters})[:, :, 0]
        label = f"{one.term.terms[0]}, times {one.term.unit} [{OUTPUT_UNITS[triad]}]"
    return Coordinate(label, _at_rows(evidence, np.broadcast_to(value, (len(seen.t), len(AXES)))))


def _at_rows(evidence: Evidence, values: FloatArray) -> FloatArray:
    """Return the mean of each row's own sensor (n,) of values at the nodes (m, 3); of all where a row has none."""
    means, axis = means_at_rows(evidence, values), evidence.axis
    own: FloatArray = means[np.arange(len(axis)), np.maximum(axis, 0)]
    return np.where(axis < 0, means.mean(axis=1), own)
