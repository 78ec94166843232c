"""The verdict of a diagnosis, and what to measure next."""

from collections.abc import Sequence

from procedures.diagnosis.effect_selection import TestedEffect
from procedures.diagnosis.result import (
    UNEXPLAINED_LOG_P,
    EffectTest,
    Finding,
    Reason,
    Verdict,
    verdict_with_excess,
)

REPEAT_CAMPAIGN = (
    "the same campaign in another order, on another day: an error that does not repeat is no error term"
)
REPEAT_SOAK = (
    "the same again, with temperature up and down, on another day: an error that does not repeat is no error term"
)


def verdict_of(findings: Sequence[Finding], left: float, unnamed: Sequence[Reason] = ()) -> Verdict:
    """Return the verdict; ``left`` is ln p of what the findings leave, ``unnamed`` speak for another cause."""
    if left < UNEXPLAINED_LOG_P or unnamed:
        return verdict_with_excess(findings)
    for word in ("ambiguous", "likely", "established"):
        if any(each.confidence == word for each in findings):
            return word
    return "consistent"


def effect_test(tried: TestedEffect) -> EffectTest:
    """Return what a diagnosis says of an effect that was tried."""
    return EffectTest(tried.candidate.effect.name, tried.test.statistic, tried.log_p, tried.log_p_adjusted)


def next_measurement_of(findings: Sequence[Finding], verdict: Verdict) -> str:
    """Return what would tell the findings' names, or whether what is left comes back; nothing if all is told."""
    told = "; ".join(dict.fromkeys(each.separate_by for each in findings if each.confidence == "ambiguous"))
    return REPEAT_CAMPAIGN if verdict in {"unexplained", "partly"} and not told else told
