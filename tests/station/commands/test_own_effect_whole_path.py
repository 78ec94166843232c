"""The whole path of an effect of one's own: planted, proposed, adopted, confirmed by a fresh campaign, right."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from procedures.units import DEG_H_PER_DEG_S
from station import cli
from station.files.effect_file import read_effect
from tests.station.campaign_writing import write_campaign
from tests.station.effect_examples import WARMING, WARMING_SIZES

NAME = "gyroscope.warming_while_warm"


def recorded(folder: Path, seed: int) -> Truth:
    """Record a unit that warms up in a room that swings, the law planted by the simulator; return how it was.

    Without the swing a lag of the temperature does nearly the same as the law.
    """
    truth = replace(
        Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0,
        temperature_swing_k=4.0, temperature_swing_period_s=400.0,
        heading_std_deg=0.02, sample_period_s=0.05, effects={NAME: dict(zip("xyz", WARMING_SIZES, strict=True))},
        terms={NAME: WARMING},
    )  # fmt: skip
    campaign = simulate_campaign(
        truth, seed, dwell_s=20.0, turns=turn_steps(1, 3.0), move_s=20.0, certificate_sigma=2e-7
    )
    write_campaign(folder, campaign, truth.sample_period_s)
    return truth.powered_on(np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[1]))


def carried_out(*arguments: str | Path) -> None:
    assert cli.run([*map(str, arguments)]) == 0


def solved(folder: Path, *more: str | Path) -> dict[str, Any]:
    out = folder.with_suffix(".json")
    carried_out("solve", folder, "--json", out, *more)
    document: dict[str, Any] = json.loads(out.read_text())
    return document


def errors(document: dict[str, Any], truth: Truth) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the errors (3,) of the gyroscopes' biases [deg/h]."""
    error: np.ndarray[Any, np.dtype[np.float64]] = (
        np.array(document["gyroscope"]["bias"]["value"]) - truth.gyro_d_deg_s * DEG_H_PER_DEG_S
    )
    return error


def test_what_one_campaign_proposes_a_fresh_one_confirms_and_is_right_with(tmp_path: Path) -> None:
    first, fresh, law, confirmed = (tmp_path / name for name in ("first", "fresh", "law.toml", "confirmed.toml"))
    found, later = tmp_path / "found.json", tmp_path / "later.json"
    recorded(first, 5)
    carried_out("diagnose", first, "--discover", "--json", found)
    carried_out("effects", "adopt", found, "--out", law)
    assert read_effect(law).term.terms == ("T * T_rate",)
    assert read_effect(law).is_only_proposed

    truth = recorded(fresh, 23)
    carried_out("diagnose", fresh, "--effects", law, "--json", later)
    carried_out("effects", "adopt", later, "--out", confirmed)
    assert not read_effect(confirmed).is_only_proposed

    without, with_it = solved(fresh), solved(fresh, "--effects", confirmed)
    assert without["residual"]["p_value"] < 1e-6
    assert with_it["residual"]["p_value"] > 1e-3
    (effect,) = with_it["effects"]
    for axis, planted in zip("xyz", WARMING_SIZES, strict=True):
        one = effect["coefficients"][axis]
        assert abs(one["value"] - planted) < 4 * one["std"] < 1.0
    assert np.all(np.abs(errors(with_it, truth)) < 4 * np.array(with_it["gyroscope"]["bias"]["std"]))
    assert np.abs(errors(with_it, truth)).max() < 0.25 * np.abs(errors(without, truth)).max()
