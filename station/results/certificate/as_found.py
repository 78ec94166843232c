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
class AsFound:
    """The comparison with the previous calibration.

    ``said`` is its own verdict then, ``verdict`` its values' against the limits of now (empty without limits).
    ``rows`` are printed lines: parameter, the value that was applied, the error it left, U of that, unit, how many
    sigmas it is, and whether it is within U. ``moved`` counts those that are not.
    """

    sha256: str
    accepted_utc: str
    status: str
    said: str
    verdict: str
    rows: tuple[tuple[str, str, str, str, str, str, bool], ...]
    moved: int


def as_found(document: Mapping[str, Any], previous: Mapping[str, Any], sha256: str) -> AsFound:
    """Compare a calibration/1 with the one of the same unit before it, whose hash is ``sha256``."""
    budget, before = measured(previous), applied(parameters(previous))
    now = {k: one for k, one in measured(document).items() if k in before and before[k].unit == one.unit}
    error = {name: one.value - before[name].value for name, one in now.items()}
    std = {
        name: hypot(one.std, budget[name].std if name in budget else before[name].std or 0.0)
        for name, one in now.items()
    }
    shown = {name: printed_scale(name, one.unit) for name, one in now.items()}
    expanded = {name: COVERAGE * u for name, u in std.items()}
    by = [u * shown[name][0] for name, u in expanded.items()]
    columns = (
        to_two_digits([values[name] * scale for name, (scale, _) in shown.items()], by)
        for values in ({name: before[name].value for name in now}, error, expanded)
    )
    rows = tuple(
        (title_of(name), *cells, shown[name][1], f"{abs(error[name]) / u if u > 0 else 0.0:.1f}",
         abs(error[name]) <= expanded[name])
        for (name, u), *cells in zip(std.items(), *columns, strict=True)
    )  # fmt: skip
    outcome = judge_previous(previous, document)
    return AsFound(
        sha256,
        previous["accepted_utc"],
        previous["status"],
        word_said(previous.get("verdict", ""), has_limits=bool(previous.get("limits"))),
        "" if outcome is None else outcome.word.replace("_", " "),
        rows,
        sum(not holds for *_, holds in rows),
    )
