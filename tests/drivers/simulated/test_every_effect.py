"""Each effect is planted without noise; its prediction here is written independently of the planting code."""

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.cube_motion import Segment, rest
from drivers.simulated.effects import EFFECTS
from drivers.simulated.truth import truth_from
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell
from procedures.effects import EFFECTS as DIAGNOSED
from procedures.positions import POSITIONS
from procedures.units import STANDARD_GRAVITY

UNIT = {
    "accel_e": [[1, 2e-3, 0], [0, 1, -1e-3], [3e-3, 0, 1]],
    "accel_d_g": [1e-3, -2e-3, 5e-4],
    "gyro_e": [[1, 1e-3, 0], [0, 1, 0], [0, -1e-3, 1]],
    "gyro_d_deg_s": [1e-4, 2e-4, -1e-4],
    "temperature_start_c": 20.0,
    "temperature_rise_k": 8.0,
    "temperature_tau_s": 1000.0,
    "magnetic_enu_ut": [-3.0, 34.0, -36.0],
    "gravity_m_s2": 9.79,
}
ENU = {
    "E": np.array([1.0, 0, 0]), "W": np.array([-1.0, 0, 0]),
    "N": np.array([0, 1.0, 0]), "S": np.array([0, -1.0, 0]),
    "U": np.array([0, 0, 1.0]), "D": np.array([0, 0, -1.0]),
}  # fmt: skip
N = 3000
INDEX = 20_000
T = 0.02 * (INDEX + np.arange(N) + 0.5)[:, None]
REST = 0.02 * (250 + np.arange(N) + 0.5)[:, None]
KELVIN = 20 + 8 * (1 - np.exp(-T / 1000)) - 25
K_PER_MIN = 60 * 8 / 1000 * np.exp(-T / 1000)
OMEGA = np.degrees(7.292115e-5)


def output(effects: dict[str, dict[str, float]], position: int, rate_deg_s: float = 0.0) -> FloatArray:
    """Noise-free output (N, 6): accelerometers [g], gyros [deg/s]; optionally turning about the vertical."""
    bench = SimulatedBench(truth_from({**UNIT, "effects": effects}), None)
    C_bn = bench.world.attitude(position)
    segment = rest(C_bn, N, position, 250)
    if rate_deg_s:
        angle = np.radians(rate_deg_s) * bench.sensor.period * np.arange(N + 1)
        segment = Segment(C_bn, N, C_bn[:, 2], angle)
    return np.broadcast_to(bench.sensor.output(segment, INDEX, 0, N), (N, 6))


def seen(position: int, vector_n: FloatArray) -> FloatArray:
    return np.array([ENU[letter] @ vector_n for letter in POSITIONS[position - 1]])


def f_b(position: int) -> FloatArray:
    return seen(position, np.array([0, 0, UNIT["gravity_m_s2"] / STANDARD_GRAVITY]))


def accel_u(position: int) -> FloatArray:
    return np.array(UNIT["accel_e"]) @ f_b(position)


def gyro_u(position: int) -> FloatArray:
    latitude = np.radians(31.17)
    return np.array(UNIT["gyro_e"]) @ seen(position, OMEGA * np.array([0, np.cos(latitude), np.sin(latitude)]))


def only(axis: int, values: FloatArray | float, triad: str) -> FloatArray:
    added = np.zeros((N, 6))
    added[:, (0 if triad == "a" else 3) + axis] = np.squeeze(values)
    return added


AD, GD = np.array(UNIT["accel_d_g"]), np.array(UNIT["gyro_d_deg_s"])
X, Y, Z = 0, 1, 2
# effect, sizes, position, what is added to the output (N, 6)
ADDED = [
    ("accelerometer.quadratic", {"x": 4e-5}, 3, lambda p: only(X, 4e-5 * accel_u(p)[X] ** 2, "a")),
    ("accelerometer.cubic", {"x": 4e-5}, 3, lambda p: only(X, 4e-5 * accel_u(p)[X] ** 3, "a")),
    ("accelerometer.scale_asymmetry", {"y": 30}, 7, lambda p: only(Y, 15e-6 * abs(accel_u(p)[Y]), "a")),
    ("accelerometer.cross_product", {"yz": 1e-3}, 9,
     lambda p: only(Y, 1e-3 * accel_u(p)[Y] * accel_u(p)[Z], "a")),
    ("accelerometer.cross_product", {"xyz": 1e-3}, 9,
     lambda p: only(X, 1e-3 * accel_u(p)[Y] * accel_u(p)[Z], "a")),
    ("accelerometer.bias_temperature", {"z": 1e-5}, 1, lambda p: only(Z, 1e-5 * KELVIN, "a")),
    ("accelerometer.scale_temperature", {"x": 50}, 1,
     lambda p: only(X, 5e-5 * KELVIN * (accel_u(p) + AD)[X], "a")),
    ("accelerometer.bias_drift", {"y": 1e-4}, 1, lambda p: only(Y, 1e-4 * T / 3600, "a")),
    ("accelerometer.relaxation", {"y": 1e-4, "tau_s": 20}, 1, lambda p: only(Y, 1e-4 * np.exp(-REST / 20), "a")),
    ("gyroscope.g_sensitivity", {"zx": 0.6}, 3, lambda p: only(Z, 0.6 / 3600 * f_b(p)[X], "g")),
    ("gyroscope.bias_temperature", {"x": 0.1}, 1, lambda p: only(X, 0.1 / 3600 * KELVIN, "g")),
    ("gyroscope.scale_temperature", {"x": 50}, 1, lambda p: only(X, 5e-5 * KELVIN * (gyro_u(p) + GD)[X], "g")),
    ("gyroscope.temperature_rate", {"x": 2.0}, 1, lambda p: only(X, 2.0 / 3600 * K_PER_MIN, "g")),
    ("gyroscope.bias_drift", {"z": 1.0}, 1, lambda p: only(Z, 1.0 / 3600 * T / 3600, "g")),
    ("gyroscope.magnetic", {"y": 0.02}, 5,
     lambda p: only(Y, 0.02 / 3600 * seen(p, np.array([-3.0, 34.0, -36.0]))[Y], "g")),
    ("gyroscope.scale_asymmetry", {"x": 100}, 3, lambda p: only(X, 5e-5 * abs(gyro_u(p)[X]), "g")),
    ("gyroscope.scale_nonlinearity", {"x": 500}, 3,
     lambda p: only(X, 5e-4 * gyro_u(p)[X] * abs(gyro_u(p)[X]), "g")),
    ("gyroscope.sagnac_sine", {"x": 100.0}, 3,
     lambda p: only(X, np.sin(100 * gyro_u(p)[X]) / 100 - gyro_u(p)[X], "g")),
    ("site.gravity", {"value": 1e-3}, 3,
     lambda p: only(X, 0, "a") + np.hstack([accel_u(p) * 1e-3 / 9.79, np.zeros(3)])),
    ("disturbance.dwell", {"position": 1, "x": 1e-3, "at_s": 20, "duration_s": 5, "hz": 3}, 1,
     lambda p: only(X, 1e-3 * np.sin(6 * np.pi * (REST - 20)) * ((REST > 20) & (REST < 25)), "a")),
    ("auxiliary.channel", {"ax": 1e-4, "period_s": 300}, 1,
     lambda p: only(X, 1e-4 * np.sin(2 * np.pi * T / 300), "a")),
    ("auxiliary.channel", {"gz": 1.0, "period_s": 300}, 1,
     lambda p: only(Z, 1 / 3600 * np.sin(2 * np.pi * T / 300), "g")),
]  # fmt: skip
by_effect = pytest.mark.parametrize(("name", "sizes", "position", "added"), ADDED)


@by_effect
def test_a_planted_effect_adds_what_its_equation_says(name, sizes, position, added) -> None:
    gained = output({name: sizes}, position) - output({}, position)
    expected = np.broadcast_to(added(position), (N, 6))
    assert np.max(np.abs(gained - expected)) < 1e-12
    assert np.max(np.abs(expected)) > 1e-10


# effect, sizes, position, vector added to the vertical seen in the cube
TILTS = [
    ("slab.tilt", {"east": 1e-4}, 9, lambda: seen(9, np.array([1e-4, 0, 0]))),
    ("slab.tilt", {"north": 1e-4}, 10, lambda: seen(10, np.array([0, 1e-4, 0]))),
    ("fixture.face_tilt", {"x_down.z": 1e-4}, 3, lambda: np.array([0, 0, 1e-4])),
    ("fixture.parallelism", {"x.z": 1e-4}, 3, lambda: np.array([0, 0, 5e-5])),
    ("placement.dwell", {"position": 7, "z": 1e-4}, 7, lambda: np.cross([0, 0, 1e-4], [0, -1, 0])),
]


@pytest.mark.parametrize(("name", "sizes", "position", "added"), TILTS)
def test_a_bench_effect_tilts_the_vertical_as_documented(name, sizes, position, added) -> None:
    plain, tilted = (SimulatedBench(truth_from({"effects": e}), None).world for e in ({}, {name: sizes}))
    gained = (tilted.attitude(position) - plain.attitude(position))[:, 2]
    assert np.max(np.abs(gained - added())) < 1e-8
    nothing = {key: 0.0 if key in EFFECTS[name].keys else size for key, size in sizes.items()}
    same = SimulatedBench(truth_from({"effects": {name: nothing}}), None).world
    assert np.array_equal(same.attitude(position), plain.attitude(position))


def test_an_effect_elsewhere_leaves_other_positions_alone() -> None:
    plain, off = (SimulatedBench(truth_from({"effects": e}), None).world for e in ({}, {
        "placement.dwell": {"position": 7, "z": 1e-4}, "fixture.face_tilt": {"x_down.z": 1e-4}}))  # fmt: skip
    for position in (1, 2, 5, 8, 12):
        assert np.array_equal(plain.attitude(position), off.attitude(position))


def test_a_wrong_label_rests_the_cube_where_it_says() -> None:
    label = {"placement.label": {"position": 3, "actual": 4}}
    world = SimulatedBench(truth_from({"effects": label}), None).world
    assert np.array_equal(world.attitude(3), world.attitude(4))
    assert not np.array_equal(world.attitude(3), world.attitude(3, seated=False))


def test_an_azimuth_puts_true_north_west_of_the_slabs_mark() -> None:
    world = SimulatedBench(truth_from({"effects": {"site.azimuth": {"value": 0.01}}}), None).world
    # position 9, NWU: body X along the slab's North mark, Y along its West
    assert np.allclose(world.attitude(9) @ [0, 1, 0], [np.cos(0.01), np.sin(0.01), 0], atol=1e-12)


def test_a_fast_clock_makes_a_sample_shorter() -> None:
    plain, fast = (SimulatedBench(truth_from({"effects": e}), None) for e in ({}, {"clock.rate": {"value": 1e3}}))
    step = Dwell(1, 100.0)
    counts = [bench.perform(step).accel.sum(0)[0] for bench in (plain, fast)]
    assert abs(counts[1] / counts[0] - 1 / 1.001) < 1e-5


@pytest.mark.parametrize("rate", [-40.0, 25.0])
def test_turn_effects_follow_the_rate(rate: float) -> None:
    for name, size, added in (
        ("gyroscope.scale_asymmetry", 100.0, lambda u: 5e-5 * abs(u)),
        ("gyroscope.scale_nonlinearity", 5.0, lambda u: 5e-6 * u * abs(u)),
        ("gyroscope.sagnac_sine", 0.01, lambda u: np.sin(0.01 * u) / 0.01 - u),
    ):
        plain, with_effect = output({}, 1, rate)[:, 3], output({name: {"x": size}}, 1, rate)[:, 3]
        assert np.max(np.abs(with_effect - plain - added(plain - GD[X]))) < 1e-9 * abs(rate)


def test_every_effect_is_held_to_a_prediction_here_or_to_the_columns_of_a_diagnosis() -> None:
    tried = {row[0] for row in (*ADDED, *TILTS)} | {"placement.label", "site.azimuth", "clock.rate"}
    assert tried <= set(EFFECTS)
    diagnosed = {effect.name for effect in DIAGNOSED}
    for name in set(EFFECTS) - tried - diagnosed:
        pytest.fail(f"{name} has no row in ADDED or TILTS, and no diagnosis knows it.", pytrace=False)
