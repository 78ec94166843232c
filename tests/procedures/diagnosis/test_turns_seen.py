"""What a turn by itself shows: the scale factor, next to the output at rest; by its own sigma."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site, TurnRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.rotation_summary import TurnSeen, left_open, pooled, turns_seen

PERIOD, SCALE, BIAS, NOISE = 0.01, 1.013, 0.02, 0.01  # s; output/(deg/s), output, output a sample
REST_S, SPEED = 15.0, 40.0  # s, deg/s


def recorded(seed: int, angle_deg: float, direction: str = "+", rest_s: float = REST_S) -> TurnRecord:
    """Return a turn about z at a speed that rises and falls as a sine, its integral in closed form."""
    seconds = angle_deg / SPEED * 2
    t = PERIOD * np.arange(round((2 * rest_s + seconds) / PERIOD))
    inside = np.clip((t - rest_s) / seconds, 0, 1)
    angle = angle_deg * (inside - np.sin(2 * np.pi * inside) / (2 * np.pi))
    rate = np.diff(angle, append=angle[-1]) / PERIOD * (1 if direction == "+" else -1)
    gyro = np.zeros((len(t), 3))
    gyro[:, 2] = SCALE * rate + BIAS + NOISE * np.random.default_rng(seed).standard_normal(len(t))
    return TurnRecord(f"turn_{seed}", "z", direction, max(round(angle_deg / 360), 1), 9, series(t, gyro))


def series(t: np.ndarray, gyro: np.ndarray) -> RateSeries:
    return RateSeries(t=t, temperature=np.full(len(t), np.nan), period=PERIOD, accel=None, gyro=gyro)


def seen(*turns: TurnRecord, nominal: float | None = 1.0) -> list[TurnSeen]:
    site = Site(0.8, 9.80665, 0.02, None)
    scale = {} if nominal is None else {"gyroscope": nominal}
    closure = ProcedureSigma(0.001, float(np.radians(0.001)))
    return turns_seen(
        [Campaign("M", "S", False, site, (), turns, closure, Fixture({}, np.eye(3)), nominal_scale=scale)]
    )


def test_scale_factor_and_output_at_rest_of_one_turn_are_the_truth_within_their_sigma() -> None:
    off = list[tuple[float, float]]()
    for seed in range(10):
        (one,) = seen(recorded(seed, 1080.0))
        assert one.scale is not None
        assert one.at_rest is not None
        off.append(((one.scale[0] - SCALE) / one.scale[1], (one.at_rest[0] - BIAS) / one.at_rest[1]))
    assert np.all(np.abs(off) < 4)
    assert np.all(np.std(off, axis=0) > 0.3)  # its sigma is no empty promise either


def test_both_directions_and_several_turns_are_put_together() -> None:
    turns = seen(recorded(1, 720.0), recorded(2, 720.0, "-"), recorded(3, 1440.0))
    assert [each.revolutions for each in turns] == [2, -2, 4]
    value, std = pooled(turns)[2]
    assert abs(value - SCALE) < 4 * std
    assert not any("direction" in each for each in left_open(turns))
    assert any("direction" in each for each in left_open(turns[:1]))


@pytest.mark.parametrize("angle_deg", [180.0, 500.0])
def test_what_was_no_whole_turn_has_an_angle_and_no_scale_factor(angle_deg: float) -> None:
    (one,) = seen(recorded(4, angle_deg))
    assert one.scale is None
    assert one.turned_deg is not None
    assert abs(one.turned_deg[0] - SCALE * angle_deg) < 4 * one.turned_deg[1]
    assert any("--reference" in each for each in left_open([one]))


def test_a_turn_the_other_way_is_named_so() -> None:
    reported = recorded(6, 720.0)
    assert reported.series.gyro is not None
    (one,) = seen(replace(reported, series=replace(reported.series, gyro=-reported.series.gyro)))
    assert one.scale is None
    assert "a scale factor of z: it turned the other way (state turn:-z)" in left_open([one])
    assert not any("no whole turn" in each or "rest for 2 s" in each for each in left_open([one]))
