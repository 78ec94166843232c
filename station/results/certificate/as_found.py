"""As found: how wrong the unit was while its previous calibration was still applied.

Applying the previous parameters leaves the errors that this calibration finds: for a parameter p the shift
``p_now - p_previous``, with U = 2 sqrt(u_now^2 + u_previous^2). What both share (cube, slab, gravity) is counted
twice: U is rather too wide than too narrow.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any

from station.results.certificate.conformity import judge_previous
from station.results.certificate.printed_results import MeasuredParameter, measured, to_two_digits, unit_of
from station.results.parameters_by_name import applied, parameters, title_of
from station.results.verdict import stored_verdict_said

COVERAGE = 2.0


@dataclass(frozen=True, slots=True)
class AsFoundRow:
    """A printed line: the value that was applied, the error it left, U of that, and how many sigmas it is."""

    title: str
    before: str
    error: str
    expanded: str
    sigmas: str
    unit: str
    holds: bool


@dataclass(frozen=True, slots=True)
class AsFound:
    """The comparison with the previous calibration.

    ``said`` is its own verdict then, ``verdict`` its values' against the limits of now (empty without limits).
    """

    sha256: str
    accepted_utc: str
    status: str
    said: str
    verdict: str
    reason: str
    rows: tuple[AsFoundRow, ...]

    @property
    def moved(self) -> int:
        """How many parameters moved by more than U."""
        return sum(not row.holds for row in self.rows)


def as_found(document: Mapping[str, Any], previous: Mapping[str, Any], sha256: str) -> AsFound:
    """Compare a calibration/1 with the one of the same unit before it, whose hash is ``sha256``."""
    now, before = measured(document), applied(parameters(previous))
    budget = measured(previous)
    rows = [
        _row(name, one, before[name].value, budget[name].std if name in budget else before[name].std or 0.0)
        for name, one in now.items()
        if name in before and before[name].unit == one.parameter.unit
    ]
    outcome = judge_previous(previous, document)
    return AsFound(
        sha256,
        previous["accepted_utc"],
        previous["status"],
        stored_verdict_said(previous, ""),
        "" if outcome is None else outcome.word.replace("_", " "),
        "" if outcome is None else outcome.reason,
        tuple(rows),
    )


def _row(name: str, now: MeasuredParameter, before: float, std: float) -> AsFoundRow:
    scale, unit = unit_of(now.parameter)
    error, combined = now.parameter.value - before, hypot(now.std, std)
    expanded = COVERAGE * combined
    texts = [to_two_digits([value * scale], [expanded * scale])[0].rstrip() for value in (before, error, expanded)]
    sigmas = abs(error) / combined if combined > 0 else 0.0
    return AsFoundRow(title_of(name), texts[0], texts[1], texts[2], f"{sigmas:.1f}", unit, abs(error) <= expanded)
