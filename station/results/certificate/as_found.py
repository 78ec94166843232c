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
from station.results.certificate.printed_results import measured, to_two_digits
from station.results.parameters_by_name import applied, parameters, printed_scale, title_of
from station.results.verdict import word_said

COVERAGE = 2.0


@dataclass(frozen=True, slots=True)
class Shift:
    """By how much a parameter had moved, in the unit of files: what was applied, the error it left, U of that."""

    name: str
    unit: str
    applied: float
    error: float
    expanded: float

    @property
    def is_within(self) -> bool:
        """Whether the error is within its U."""
        return abs(self.error) <= self.expanded


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
    shifts: tuple[Shift, ...]

    @property
    def moved(self) -> int:
        """How many parameters had moved by more than U."""
        return sum(not one.is_within for one in self.shifts)

    @property
    def rows(self) -> list[tuple[str, str, str, str, str, str, bool]]:
        """Printed lines: parameter, applied, error, U, unit, how many sigmas that is, whether within U."""
        shown = [printed_scale(one.name, one.unit) for one in self.shifts]
        by = [one.expanded * scale for one, (scale, _) in zip(self.shifts, shown, strict=True)]
        columns = (
            to_two_digits(
                [getattr(one, what) * scale for one, (scale, _) in zip(self.shifts, shown, strict=True)], by
            )
            for what in ("applied", "error", "expanded")
        )
        return [
            (title_of(one.name), *cells, unit, f"{sigmas(one):.1f}", one.is_within)
            for one, (_, unit), *cells in zip(self.shifts, shown, *columns, strict=True)
        ]


def sigmas(shift: Shift) -> float:
    """Return how many sigmas of both calibrations a parameter had moved, 0 where they have none."""
    return COVERAGE * abs(shift.error) / shift.expanded if shift.expanded > 0 else 0.0


def as_found(document: Mapping[str, Any], previous: Mapping[str, Any], sha256: str) -> AsFound:
    """Compare a calibration/1 with the one of the same unit before it, whose hash is ``sha256``."""
    budget, before = measured(previous), applied(parameters(previous))
    now = {k: one for k, one in measured(document).items() if k in before and before[k].unit == one.unit}
    shifts = tuple(
        Shift(
            name, one.unit, before[name].value, one.value - before[name].value,
            COVERAGE * hypot(one.std, budget[name].std if name in budget else before[name].std or 0.0),
        )
        for name, one in now.items()
    )  # fmt: skip
    outcome = judge_previous(previous, document)
    return AsFound(
        sha256,
        previous["accepted_utc"],
        previous["status"],
        word_said(previous.get("verdict", ""), has_limits=bool(previous.get("limits"))),
        "" if outcome is None else outcome.word.replace("_", " "),
        shifts,
    )
