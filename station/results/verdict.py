"""The verdict of a calibration against the limits of its model, and why, in words a technician understands.

A value is held against its limit as `fixtures_db.imu_models` says (guarded acceptance, JCGM 106:2012, 8.3). FAIL
if any is outside; else NOT_MEASURED if a limited parameter was not estimated or there are no limits; else PASS.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from fixtures_db.imu_models import Limit
from station.results.parameters_by_name import Parameter, parameters, shown, shown_scale, title_of
from station.text import plural

VerdictWord = Literal["PASS", "FAIL", "NOT_MEASURED"]


@dataclass(frozen=True, slots=True)
class JudgedLimit:
    """A limit and the parameter it was held against, None if that was not estimated.

    ``share`` says how much of the way from the middle to its limit the value stands, 1 at the limit; None where
    a single open limit has no middle.
    """

    limit: Limit
    parameter: Parameter | None
    word: VerdictWord
    share: float | None = None


@dataclass(frozen=True, slots=True)
class LimitVerdict:
    """The verdict, what led to it, and why, in words."""

    word: VerdictWord
    judged: tuple[JudgedLimit, ...]
    reason: str

    @property
    def in_words(self) -> str:
        """The verdict's word as people read it."""
        return verdict_in_words(self.word, has_limits=bool(self.judged))

    @property
    def sentence(self) -> str:
        """The verdict and its reason."""
        return f"{self.in_words}: {self.reason}"

    @property
    def exit_code(self) -> int:
        """What a command ends with: 1 on FAIL."""
        return int(self.word == "FAIL")


def verdict_in_words(word: str, *, has_limits: bool) -> str:
    """Return a stored verdict's word as people read it: without limits values were measured and not judged."""
    return "NO LIMITS" if word == "NOT_MEASURED" and not has_limits else word.replace("_", " ")


def judge(
    document: Mapping[str, Any], limits: Sequence[Limit], std: Mapping[str, float] | None = None
) -> LimitVerdict:
    """Hold a `solution/1` or `calibration/1` document against limits, one for each axis.

    ``std`` are combined standard uncertainties by parameter; where there is none, the document's is used.
    """
    found = {name: replace(one, std=(std or {}).get(name, one.std)) for name, one in parameters(document).items()}
    judged = tuple(_judged(limit, found.get(limit.parameter)) for limit in limits)
    word = worst([one.word for one in judged])
    origin = document.get("provenance", document)
    return LimitVerdict(word, judged, _reason(word, judged, origin["model"], origin["serial"]))


def worst(words: Sequence[VerdictWord]) -> VerdictWord:
    """Return the verdict on all of several limits; without any nothing was measured."""
    if "FAIL" in words:
        return "FAIL"
    return "NOT_MEASURED" if "NOT_MEASURED" in words or not words else "PASS"


def _judged(limit: Limit, parameter: Parameter | None) -> JudgedLimit:
    if parameter is None or parameter.unit != limit.unit:
        return JudgedLimit(limit, None, "NOT_MEASURED")
    low, high = limit.accepted(parameter.std)
    word: VerdictWord = "PASS" if low <= parameter.value <= high else "FAIL"
    return JudgedLimit(limit, parameter, word, _share(parameter.value, low, high))


def _share(value: float, low: float, high: float) -> float | None:
    if math.isfinite(low) and math.isfinite(high):
        half = (high - low) / 2
        return abs(value - (low + high) / 2) / half if half > 0 else math.inf
    if math.isfinite(high):
        return value / high if high > 0 else None
    return low / value if value > 0 and low > 0 else None


def _reason(word: VerdictWord, judged: Sequence[JudgedLimit], model: str, serial: str) -> str:
    unit = f"{model} {serial}"
    if not judged:
        return f"no limits are stored for {model}; `station fixtures limits {model} --import FILE` stores them"
    if word == "FAIL":
        outside = [one for one in judged if one.word == "FAIL"]
        worst = max(outside, key=lambda one: one.share if one.share is not None else math.inf)
        also = f": {_names(outside)}" if len(outside) > 1 else ""
        return (
            f"{unit} exceeds {len(outside)} of {plural(len(judged), 'limit')} of its model{also}. "
            f"{'Largest excess' if also else 'It is'}: {_against(worst)}"
        )
    missing = [one for one in judged if one.word == "NOT_MEASURED"]
    if missing:
        return f"{len(missing)} of {len(judged)} limited parameters of {unit} were not measured: {_names(missing)}"
    tightest = max(judged, key=lambda one: (one.share or 0.0, title_of(one.limit.parameter)))
    band = tightest.limit.guard_band
    return (
        f"{unit} is within {'the only limit' if len(judged) == 1 else f'all {len(judged)} limits'} of its model. "
        f"Closest to its limit: {title_of(tightest.limit.parameter)}, which uses "
        f"{100 * (tightest.share or 0.0):.0f} % of "
        f"{f'the accepted range (limit minus {band:g} u)' if band else 'the allowed range'}"
    )


def what_to_do(word: VerdictWord, next_measurement: str, *, doubt: str = "", has_limits: bool = True) -> str:
    """Return what a reader of the verdict does now, in a sentence or two."""
    if doubt:
        return "Do not use this calibration. Do what the verdict says, then calibrate again."
    if not has_limits:
        done = "Check the values yourself: no limits are stored for this model."
    elif word == "PASS":
        done = "Use this calibration."
    elif word == "FAIL":
        done = "Do not use the unit where these limits apply. Repair it, or decide on a restricted use."
    else:
        done = "Record the steps that determine the missing parameters, then calibrate again."
    return f"{done} To improve the model: {next_measurement.rstrip('.')}." if next_measurement else done


def _names(judged: Sequence[JudgedLimit]) -> str:
    names = [title_of(one.limit.parameter) for one in judged]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _against(judged: JudgedLimit) -> str:
    """Say a value with its limit."""
    assert judged.parameter is not None
    text, unit = shown(judged.parameter)
    return f"{judged.parameter.title}, {text} {unit}".rstrip() + f"; limit {judged_in_words(judged)}"


def limit_in_words(limit: Limit) -> str:
    """Return a limit as people read it."""
    _, unit = shown_scale(limit.parameter, limit.unit)
    guard = f", minus {limit.guard_band:g} u" if limit.guard_band else ""
    return f"{_ends(limit, limit.low, limit.high)} {unit}".rstrip() + guard


def judged_in_words(judged: JudgedLimit) -> str:
    """Return a limit and, where it is guarded, what of it the value's own uncertainty leaves."""
    text, known = limit_in_words(judged.limit), judged.parameter
    if not judged.limit.guard_band or known is None or known.std is None:
        return text
    low, high = judged.limit.accepted(known.std)
    if low > high:
        return f"{text} (u is too large: no value is accepted)"
    ends = _ends(judged.limit, *(end if math.isfinite(end) else None for end in (low, high)))
    return f"{text}: {ends}"


def _ends(limit: Limit, low: float | None, high: float | None) -> str:
    scale, _ = shown_scale(limit.parameter, limit.unit)
    first, last = (None if end is None else f"{end * scale:.6g}" for end in (low, high))
    if first is None or last is None:
        return f"at least {first}" if last is None else f"at most {last}"
    return f"+-{last}" if low == -(high or 0.0) else f"{first} to {last}"
