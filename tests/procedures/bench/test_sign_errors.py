"""Sensors that count backwards, and turns and positions recorded the wrong way: named rightly, or left open."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.bench.sign_errors import earth_signs
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign
from procedures.counts.sample_records import RateSeries, Series
from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS

OPPOSITE = {"+": "-", "-": "+"}
OTHER_FACE = {1: 3, 3: 1, 2: 4, 4: 2, 5: 7, 7: 5, 6: 8, 8: 6, 9: 11, 11: 9, 10: 12, 12: 10}
# what a diagnosis tries in addition to signs
SOME = [each for each in EFFECTS if each.name.startswith(("placement.", "gyroscope.g_", "procedure.", "slab."))]
TURNS, GYROS = "labelled with the opposite direction", "gyroscopes' signs are inverted"
UNDETERMINED = "does not determine which"


@cache
def recorded(seed: int, resolves: bool = True) -> Campaign:
    """Twelve positions and six turns; a unit that does not resolve the Earth's rate is a coarse one.

    Seed 3 counts; another seed puts out rates.
    """
    truth = replace(Truth.example(seed), sample_period_s=0.05)
    if not resolves:
        truth = replace(truth, gyro_k=truth.gyro_k / 200, gyro_arw_deg_rt_s=0.05, gyro_instability_dph=60.0)
    counted = simulate_campaign(truth, seed, dwell_s=10.0)
    return counted if seed == 3 else replace(changed(counted, as_rates), counts=False)


def as_rates(series: Series) -> RateSeries:
    assert series.gyro is not None
    assert series.accel is not None
    of_both = (series.gyro / series.period, series.accel / series.period)
    return RateSeries(series.t, *of_both, series.temperature, series.period, series.starts)


def changed(campaign: Campaign, change: Callable[[Series], Series]) -> Campaign:
    """Return the campaign with every step's series changed."""
    return replace(
        campaign,
        dwells=tuple(replace(each, series=change(each.series)) for each in campaign.dwells),
        turns=tuple(replace(each, series=change(each.series)) for each in campaign.turns),
    )


def turned_round(campaign: Campaign, axes: str = "xyz") -> Campaign:
    turns = (replace(t, direction=OPPOSITE[t.direction]) if t.axis in axes else t for t in campaign.turns)
    return replace(campaign, turns=tuple(turns))


def negated(campaign: Campaign, triad: str, axes: Sequence[int] = (0, 1, 2)) -> Campaign:
    def negate(series: Series) -> Series:
        values = getattr(series, triad).copy()
        values[:, list(axes)] *= -1
        return replace(series, **{triad: values})  # type: ignore[arg-type]

    return changed(campaign, negate)


def upside_down(campaign: Campaign) -> Campaign:
    dwells = (replace(each, position=OTHER_FACE[each.position]) for each in campaign.dwells)
    return replace(campaign, dwells=tuple(dwells))


def south(campaign: Campaign) -> Campaign:
    return replace(campaign, site=replace(campaign.site, latitude=-campaign.site.latitude))


def reported(campaign: Campaign) -> str:
    """Return what a solve says of signs."""
    return "\n".join(text for text in solve([campaign]).warnings if "backwards" in text)


@pytest.mark.parametrize("seed", [3])
@pytest.mark.parametrize(
    ("wrong", "words", "never"),
    [
        (lambda c: c, (), ("backwards",)),
        (turned_round, ("all turns are labelled with the opposite direction: ",), ("inverted",)),
        (lambda c: negated(c, "gyro"), ("the gyroscopes' signs are inverted: ",), (TURNS,)),
        (lambda c: negated(c, "gyro", [1]), ("the sign of gyroscope y is inverted: ",), (TURNS,)),
        (lambda c: turned_round(c, "xz"), ("turns about x are", "turns about z are"), ("inverted", "about y")),
        (lambda c: negated(c, "accel", [1]), ("the sign of accelerometer y is inverted: ",), ("exchanged",)),
        (upside_down, ("or all positions are recorded upside down",), ()),
        (south, (), ("backwards",)),
    ],
    ids=["none", "all turns", "all gyros", "a gyro", "two pairs", "an accelerometer", "upside down",
         "a wrong hemisphere"],
)  # fmt: skip
def test_what_counts_backwards_is_named_rightly(
    wrong: Callable[[Campaign], Campaign], words: Sequence[str], never: Sequence[str], seed: int
) -> None:
    words_found = reported(wrong(recorded(seed)))
    assert all(word in words_found for word in words)
    assert not any(word in words_found for word in never)


@pytest.mark.parametrize("seed", [3])
@pytest.mark.parametrize("wrong", [turned_round, lambda c: negated(c, "gyro")])
def test_where_the_gyroscopes_do_not_resolve_the_earth_rate_both_are_named(
    wrong: Callable[[Campaign], Campaign], seed: int
) -> None:
    words_found = reported(wrong(recorded(seed, resolves=False)))
    assert all(word in words_found for word in ("all turns are " + TURNS + ", or the " + GYROS, UNDETERMINED))


def test_a_diagnosis_turns_them_round_says_so_and_finds_the_truth() -> None:
    found = diagnose([turned_round(recorded(3))], SOME)
    [finding] = [each for each in found.findings if each.unit == "direction"]
    assert (finding.effect, finding.kind) == ("placement.label", "procedure")
    assert len(finding.where["file"]) == 6
    assert not [each for each in found.findings if each.effect == "placement.label" and each is not finding]
    gyroscope, truth = found.solution.gyroscope, Truth.example(3)
    assert gyroscope is not None
    assert np.max(np.abs(gyroscope.misalignment.value - truth.gyro_e)) < 1e-3
    assert not [text for text in found.solution.warnings if "backwards" in text]


def test_without_a_dwell_the_earths_rate_shows_no_sign() -> None:
    signs = earth_signs([recorded(1)], [], np.zeros((0, 3)), np.zeros((0, 3)), np.eye(3))
    assert signs.of_faces([0, 1, 2]) == 0
