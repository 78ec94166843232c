"""Conformity with limits: guarded acceptance and its risk (JCGM 106:2012), as left and as found.

A value y with combined standard uncertainty u and v degrees of freedom is accepted within a tolerance [L, H] if

    L + w <= y <= H - w,    w = r u

where r is the limit's ``guard_band``. Without other knowledge of the true value it is distributed about y as u
times Student's t, and the probability that it is outside of the tolerance is

    p = 1 - F_v((H - y) / u) + F_v((L - y) / u)

(specific risk: of a false acceptance where y was accepted). For an accepted y it is at most 1 - F_v(r) at an open
or wide tolerance: 50 % without guard band, 5 % with r = 1.64 of a normal distribution.

As found is how wrong the unit was while its previous calibration was still applied. For a parameter p it is the
shift ``p_now - p_previous``, with U = 2 sqrt(u_now^2 + u_previous^2). What both share (cube, surface plate,
gravity) is counted twice: U is rather too wide than too narrow.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from typing import Any

from fixtures_db.imu_models import Limit
from station.results.certificate.printed_results import MeasuredParameter, measured, printed_column
from station.results.parameters_by_name import applied, parameters, printed_scale, title_of
from station.results.verdict import LimitVerdict, VerdictWord, judge, verdict_in_words, worst
from station.text import MINUS, aligned, decimals, fixed


@dataclass(frozen=True, slots=True)
class LimitComparison:
    """A value held against its limit, in the limit's unit; ``std`` and ``risk`` None without uncertainty."""

    limit: Limit
    value: float | None
    std: float | None
    dof: float
    word: VerdictWord

    @property
    def guard(self) -> float:
        """The guard band w."""
        return self.limit.guard_band * (self.std or 0.0)

    @property
    def risk(self) -> float | None:
        """The probability that the true value is outside of the tolerance."""
        if self.value is None or not self.std:
            return None
        low, high = self.limit.accepted(None)
        beyond = _cdf((self.value - high) / self.std, self.dof)
        return beyond + _cdf((low - self.value) / self.std, self.dof)


ConformityRow = tuple[str, str, str, str, str, tuple[float, float] | None, str, str]


@dataclass(frozen=True, slots=True)
class Conformity:
    """The statement of conformity: the verdict on the uncertainty of this certificate, and what it rests on.

    ``stored`` is the verdict at acceptance, which knew only the sigma of the solve.
    """

    word: VerdictWord
    against: tuple[LimitComparison, ...]
    stored: str


def conformity(document: Mapping[str, Any], results: Mapping[str, MeasuredParameter]) -> Conformity | None:
    """Hold a calibration against the limits it was judged by; None if there were none."""
    limits = [limit_of(one) for one in document.get("limits", ())]
    if not limits:
        return None
    kept = {one["parameter"]: one for one in document.get("judged", ())}
    against = tuple(_against(limit, results.get(limit.parameter), kept.get(limit.parameter)) for limit in limits)
    return Conformity(worst([one.word for one in against]), against, document.get("verdict", "NOT_MEASURED"))


def limit_of(stated: Mapping[str, Any]) -> Limit:
    """Return a limit as a calibration/1 holds it."""
    guard = stated.get("guard_band", 0.0)
    return Limit(stated["parameter"], stated.get("low"), stated.get("high"), stated["unit"], guard)


def judge_previous(previous: Mapping[str, Any], document: Mapping[str, Any]) -> LimitVerdict | None:
    """Hold the previous calibration's values against the limits of this one; None if there are none.

    Limits of what a calibration does not apply (slab, residual) are left out: they are no property of the unit.
    """
    limits = [limit_of(one) for one in document.get("limits", ())]
    mine = [limit for limit in limits if limit.parameter.split(".")[0] in previous]
    return judge(previous, mine) if mine else None


def printed(against: Sequence[LimitComparison]) -> list[ConformityRow]:
    """Return the lines of the table: parameter, value, unit, tolerance, guard band, bar, risk, word.

    The bar is (value, guard) on a scale where the tolerance is -1 to 1, None if one-sided.
    """
    scaled = [printed_scale(one.limit.parameter, one.limit.unit) for one in against]
    columns = [
        aligned([text(one, scale) for one, (scale, _) in zip(against, scaled, strict=True)])
        for text in (_value, _guard)
    ]
    return [
        (title_of(one.limit.parameter), value, unit, _tolerance(one.limit, scale), guard, _bar(one), _risk(one),
         one.word.replace("_", " "))
        for one, (scale, unit), value, guard in zip(against, scaled, *columns, strict=True)
    ]  # fmt: skip


def greatest_risk(guard_band: float) -> float:
    """Return the greatest probability that an accepted value (u normal) is beyond the end of a wide tolerance."""
    return 1 - _cdf(guard_band, math.inf)


def _against(limit: Limit, result: MeasuredParameter | None, kept: Mapping[str, Any] | None) -> LimitComparison:
    value: float
    std: float | None
    if result is not None and result.unit == limit.unit:
        value, std, dof = result.value, result.std, result.dof
    elif kept is not None and kept.get("unit") == limit.unit:
        value, std, dof = kept["value"], kept.get("std"), math.inf
    else:
        return LimitComparison(limit, None, None, math.inf, "NOT_MEASURED")
    low, high = limit.accepted(std)
    return LimitComparison(limit, value, std, dof, "PASS" if low <= value <= high else "FAIL")


def _value(one: LimitComparison, scale: float) -> str:
    if one.value is None:
        return "not measured"
    if one.std:
        return fixed(one.value * scale, decimals(2 * one.std * scale))
    return f"{one.value * scale:.3g}".replace("-", MINUS)


def _guard(one: LimitComparison, scale: float) -> str:
    return fixed(one.guard * scale, decimals(2 * one.std * scale)) if one.std else "\u2013"


def _tolerance(limit: Limit, scale: float) -> str:
    low, high = (
        None if end is None else f"{end * scale:.6g}".replace("-", MINUS) for end in (limit.low, limit.high)
    )
    if low is None or high is None:
        return f"\u2265 {low}" if high is None else f"\u2264 {high}"
    return f"\u00b1{high}" if limit.low == -(limit.high or 0.0) else f"{low} to {high}"


def _risk(one: LimitComparison) -> str:
    if one.risk is None:
        return "\u2013"
    if one.risk < 1e-3:
        return "< 0.1 %"
    return f"{fixed(100 * one.risk, 1)} %"


def _bar(one: LimitComparison) -> tuple[float, float] | None:
    low, high = one.limit.low, one.limit.high
    if low is None or high is None or one.value is None or high == low:
        return None
    half = (high - low) / 2
    return max(-1.25, min(1.25, (one.value - (low + high) / 2) / half)), min(1.0, one.guard / half)


def _cdf(t: float, dof: float) -> float:
    from scipy.special import ndtr, stdtr

    if math.isinf(t):
        return float(t > 0)
    return float(ndtr(t) if math.isinf(dof) else stdtr(dof, t))


AS_FOUND_K = 2.0  # coverage factor of errors as found: two calibrations, each of many degrees of freedom


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

    ``own_verdict`` is its own then, ``verdict`` its values' against the limits of now (empty without limits).
    """

    sha256: str
    accepted_utc: str
    status: str
    own_verdict: str
    verdict: str
    shifts: tuple[Shift, ...]

    @property
    def moved(self) -> int:
        """How many parameters had moved by more than U."""
        return sum(not one.is_within for one in self.shifts)

    @property
    def rows(self) -> list[tuple[str, str, str, str, str, str, bool]]:
        """Printed lines: parameter, applied, error, U, unit, how many sigmas that is, whether within U."""
        columns = (printed_column(self.shifts, what, "expanded") for what in ("applied", "error", "expanded"))
        return [
            (title_of(one.name), *cells, printed_scale(one.name, one.unit)[1], f"{sigmas(one):.1f}", one.is_within)
            for one, *cells in zip(self.shifts, *columns, strict=True)
        ]


def sigmas(shift: Shift) -> float:
    """Return how many sigmas of both calibrations a parameter had moved, 0 where they have none."""
    return AS_FOUND_K * abs(shift.error) / shift.expanded if shift.expanded > 0 else 0.0


def as_found(document: Mapping[str, Any], previous: Mapping[str, Any], sha256: str) -> AsFound:
    """Compare a calibration/1 with the one of the same unit before it, whose hash is ``sha256``."""
    budget, before = measured(previous), applied(parameters(previous))
    now = {k: one for k, one in measured(document).items() if k in before and before[k].unit == one.unit}
    shifts = tuple(
        Shift(
            name, one.unit, before[name].value, one.value - before[name].value,
            AS_FOUND_K * hypot(one.std, budget[name].std if name in budget else before[name].std or 0.0),
        )
        for name, one in now.items()
    )  # fmt: skip
    outcome = judge_previous(previous, document)
    return AsFound(
        sha256,
        previous["accepted_utc"],
        previous["status"],
        verdict_in_words(previous.get("verdict", ""), has_limits=bool(previous.get("limits"))),
        "" if outcome is None else outcome.word.replace("_", " "),
        shifts,
    )
