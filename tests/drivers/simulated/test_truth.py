import numpy as np
import pytest

from drivers.errors import TruthRefused, UnknownEffect
from drivers.simulated.bench_in_memory import world_with_effects
from drivers.simulated.effects import planted
from drivers.simulated.truth import Truth, load_truth, paper_truth, truth_from

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
        ("sample_period_s = 0.0", "1e-05 to 4"),
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


def test_a_planted_turn_on_bias_is_drawn_once_with_the_unit_s_own() -> None:
    planted = {"accelerometer.turn_on_bias": {"value": 3e-3}, "gyroscope.turn_on_bias": {"value": 40.0}}
    truth = Truth(accel_turn_on_g=4e-3, effects={**planted, "clock.rate": {"value": 1.0}})
    on = [truth.powered_on(np.random.default_rng(seed)) for seed in range(300)]
    assert np.std([each.accel_d_g for each in on]) == pytest.approx(5e-3, rel=0.1)
    assert 3600 * np.std([each.gyro_d_deg_s for each in on]) == pytest.approx(40.0, rel=0.1)
    assert set(on[0].effects) == {"clock.rate"}


def test_the_unit_of_the_paper_is_that_of_its_tables() -> None:
    """Yao, Hu, He 2018: off-diagonals and biases in thousandths, items of 0.04 mm on a side of 400 mm."""
    unit = paper_truth()
    assert unit.accel_k.tolist() == [1020.0, 1015.0, 1018.0]
    off = unit.accel_e - np.diag(np.diag(unit.accel_e))
    np.testing.assert_allclose(off * 1000, [[0, 1, 3], [2, 0, 1], [3, 2, 0]], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(unit.accel_e, axis=1), 1.0, atol=1e-7)
    assert unit.accel_d_g.tolist() == [0.001, 0.002, 0.001]
    items = np.rint(unit.faces_rad / 1e-4).astype(int)
    assert items.tolist() == [[1, 0], [0, 3], [0, 3], [5, 0], [0, 3], [5, 0]]
    np.testing.assert_allclose(unit.faces_rad, items * 1e-4)
    assert (unit.local_gravity, unit.gyro_instability_dph, unit.serial) == (9.80665, 0.0, "P1")


def test_examples_are_of_the_size_that_real_units_have() -> None:
    units = [Truth.example(seed) for seed in range(150)]
    spread = {
        "accel_k": (1000.0, 30.0), "accel_d_g": (0.0, 2e-3), "gyro_k": (36000.0, 500.0),
        "gyro_d_deg_s": (0.0, 2e-4),
        "faces_rad": (0.0, 3e-5), "slab_tilt_rad": (0.0, 3e-5),
    }  # fmt: skip
    for name, (mean, std) in spread.items():
        drawn = np.array([getattr(unit, name) for unit in units])
        assert drawn.std() == pytest.approx(std, rel=0.15), name
        assert drawn.mean() == pytest.approx(mean, abs=0.3 * std), name
    for name, std in (("accel_e", 2e-3), ("gyro_e", 7e-4)):
        off = np.array([getattr(unit, name)[~np.eye(3, dtype=bool)] for unit in units])
        assert off.std() == pytest.approx(std, rel=0.1), name
    assert units[7].serial == "SIM-7"


def test_gravity_is_as_given_or_that_of_the_ellipsoid() -> None:
    assert Truth(gravity_m_s2=9.81).local_gravity == 9.81
    assert Truth(latitude_deg=45.0).local_gravity == pytest.approx(9.80620, abs=1e-5)  # WGS 84
    assert Truth(latitude_deg=45.0, height_m=1000.0).local_gravity == pytest.approx(9.80620 - 3.085e-3, abs=2e-5)
