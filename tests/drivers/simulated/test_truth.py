import numpy as np
import pytest

from drivers.simulated.bench_in_memory import world_with_effects
from drivers.simulated.effects import planted
from drivers.simulated.errors import TruthRefused, UnknownEffect
from drivers.simulated.truth import Truth, load_truth, truth_from

TEXT = """
serial = "A-7"
accel_k = [1020, 1015, 1018]
slab_azimuth_rad = 1e-3
imu_axes = ["-y", "+x", "+z"]
[effects."accelerometer.quadratic"]
x = 4e-5
[effects.fixture.face_tilt]
x_up.y = 1e-5
"""


def test_a_truth_is_read_from_toml_with_effects_by_quoted_or_dotted_name() -> None:
    truth = load_truth(TEXT)
    assert truth.serial == "A-7"
    assert truth.accel_k.tolist() == [1020.0, 1015.0, 1018.0]
    assert truth.effects == {"accelerometer.quadratic": {"x": 4e-5}, "fixture.face_tilt": {"x_up.y": 1e-5}}
    world = world_with_effects(truth)
    assert world.faces[0].tolist() == [1e-5, 0.0]
    assert world.C_sb.tolist() == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("acel_k = [1, 2, 3]", "accel_k"),
        ("accel_k = [1, 2]", "shape \\(3,\\)"),
        ("gravity_m_s2 = nan", "finite"),
        ("gravity_m_s2 = true", "finite"),
        ("gravity_m_s2 = 'x'", "numbers"),
        ("serial = 3", "text"),
        ("sample_period_s = 0.0", "above 0"),
        ("imu_axes = ['+x', '+y', '-z']", "right-handed"),
        ("imu_axes = '+x'", "right-handed"),
        ("effects = 3", "effects"),
        ("effects.slab = 'much'", "table"),
        ("effects.slab.tilt.east = 'much'", "finite number"),
        ("= 3", "TOML"),
    ],
)
def test_a_truth_that_breaks_a_rule_is_refused_naming_what_is_accepted(text: str, named: str) -> None:
    with pytest.raises(TruthRefused, match=named):
        load_truth(text)


@pytest.mark.parametrize(
    ("effects", "named"),
    [
        ({"accelerometer.quadric": {"x": 1.0}}, "accelerometer.quadratic"),
        ({"slab.tilt": {"up": 1.0}}, "east, north"),
        ({"placement.dwell": {"position": 13.0, "x": 1e-4}}, "1 to 12"),
        ({"placement.label": {"position": 3.0, "actual": 40.0}}, "0 to 12"),
    ],
)
def test_an_unknown_effect_or_coefficient_is_refused_naming_those_there_are(effects: dict, named: str) -> None:
    with pytest.raises((UnknownEffect, TruthRefused), match=named):
        world_with_effects(truth_from({"effects": effects}))
    with pytest.raises((UnknownEffect, TruthRefused), match=named):
        planted(effects)


def test_turn_on_biases_are_one_draw_per_power_on() -> None:
    truth = truth_from({"accel_turn_on_g": 1e-4, "gyro_turn_on_dph": 1.0})
    draws = np.array([truth.powered_on(np.random.default_rng(seed)).accel_d_g for seed in range(200)])
    assert abs(np.std(draws) / 1e-4 - 1) < 4 / np.sqrt(2 * draws.size)
    assert truth.powered_on(np.random.default_rng(1)).powered_on(np.random.default_rng(2)).accel_turn_on_g == 0


def test_examples_differ_by_seed_and_have_rows_of_unit_length() -> None:
    first, second = Truth.example(1), Truth.example(2)
    assert first.serial != second.serial
    assert np.allclose(np.linalg.norm(first.accel_e, axis=1), 1.0, atol=1e-12)
    assert not np.allclose(first.accel_d_g, second.accel_d_g)
