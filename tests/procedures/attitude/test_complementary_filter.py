import numpy as np
import pytest
from scipy.signal import lsim
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude import complementary_kernels as mixing_kernels
from procedures.attitude.attitude_log import AttitudeLog, down_of, inclination, roll_pitch_of
from procedures.attitude.complementary_filter import ComplementaryFilter
from procedures.attitude.complementary_gains import PAPER_GAINS, ComplementaryGains
from procedures.attitude.gain_tuning import FOLDS, grid_of_taus, tune
from procedures.errors import ErrorCode, NotObservable
from procedures.positions import nominal_C_lb
from tests.drivers.simulated.flight import paper_bench
from tests.refusals import refused

G = 9.80665
FRD_OF_CUBE = np.diag([1.0, -1.0, -1.0])


def wavy(seed: int = 3, n: int = 4000, dt: float = 0.01) -> AttitudeLog:
    """Random smooth rates and specific forces about level, with an airspeed."""
    rng = np.random.default_rng(seed)
    slow = np.cumsum(rng.standard_normal((n, 6)), axis=0) * 1e-3
    force = np.array([0.0, 0.0, -G]) + slow[:, 3:]
    return AttitudeLog(np.arange(n) * dt, slow[:, :3], force, 50.0 + slow[:, 0])


def still(down: FloatArray, bias: float = 0.0, n: int = 3000, dt: float = 0.01) -> AttitudeLog:
    return AttitudeLog(np.arange(n) * dt, np.full((n, 3), bias), np.tile(-G * down, (n, 1)))


def damping(gains: ComplementaryGains) -> float:
    """Return the loop's damping; 1 for gains of the form of (15)."""
    return float(0.5 * np.sqrt(gains.k1 / gains.k2))


def test_gains_of_a_time_constant_are_those_of_equation_15() -> None:
    gains = ComplementaryGains.of_time_constant(12.5)
    assert gains.k1 == pytest.approx(2 / 12.5)
    assert gains.k1 * gains.k2 == pytest.approx(1 / 12.5**2)
    assert damping(gains) == pytest.approx(1.0)
    assert damping(PAPER_GAINS) == pytest.approx(1.265, abs=1e-3)
    with refused(ValueError, None, "0"):
        ComplementaryGains.of_time_constant(0.0)


@pytest.mark.parametrize("printed", [False, True])
def test_small_angles_follow_the_transfer_function_of_equation_1(printed: bool) -> None:
    dt, n, step, bias = 0.01, 6000, 0.01, 2e-3
    t = np.arange(n) * dt
    force = np.tile(G * np.array([0.0, 0.0, -1.0]), (n, 1))
    force[1:] = -G * down_of(np.array(step), np.array(0.0))  # roll as the accelerometer has it: a step
    rate = np.zeros((n, 3))
    rate[1:, 0] = bias
    log = AttitudeLog(t, rate, force)
    found = ComplementaryFilter(aid="paper-airspeed" if printed else "none").run(log)
    roll = found[:, 0] if printed else roll_pitch_of(found)[0]
    k1, k2 = PAPER_GAINS.k1, PAPER_GAINS.k2
    by_angle = lsim(([k1, k1 * k2], [1, k1, k1 * k2]), np.full(n, step), t)[1]
    by_rate = lsim(([1, 0], [1, k1, k1 * k2]), np.full(n, bias), t)[1]
    assert np.abs(roll - by_angle - by_rate).max() < 2e-3 * step + dt * bias


@pytest.mark.parametrize("position", range(1, 13))
def test_every_cube_position_reads_as_well_as_any(position: int) -> None:
    down = -FRD_OF_CUBE @ nominal_C_lb(position)[2]
    mixer = ComplementaryFilter(ComplementaryGains.of_time_constant(2.0))
    found = mixer.run(still(down, bias=2.4e-4))
    assert np.degrees(inclination(found[-1], down)) < 1e-3
    across = mixer.gyro_bias - down * (down @ mixer.gyro_bias)
    assert across == pytest.approx(2.4e-4 * (np.ones(3) - down * down.sum()), abs=1e-6)


def test_it_comes_back_from_upside_down() -> None:
    down = np.array([0.0, 0.0, 1.0])
    log = still(down, n=20000)
    log.f_b[0] *= -1  # the first sample says upside down, exactly
    assert (
        np.degrees(inclination(ComplementaryFilter(ComplementaryGains.of_time_constant(5.0)).run(log)[-1], down))
        < 0.1
    )


def test_time_stamps_count_not_samples() -> None:
    log = wavy()
    fine = ComplementaryFilter(ComplementaryGains.of_time_constant(3.0)).run(log)
    pairs = {"rate": log.omega_b[1:].reshape(-1, 3)[: len(log.t) // 2 * 2 - 2], "force": log.f_b[1:]}
    rate = pairs["rate"].reshape(-1, 2, 3).mean(axis=1)
    force = pairs["force"][: 2 * len(rate)].reshape(-1, 2, 3).mean(axis=1)
    half = AttitudeLog(
        np.concatenate(([log.t[0]], log.t[2 : 2 * len(rate) + 1 : 2])),
        np.vstack([log.omega_b[:1], rate]), np.vstack([log.f_b[:1], force]),
    )  # fmt: skip
    coarse = ComplementaryFilter(ComplementaryGains.of_time_constant(3.0)).run(half)
    assert np.degrees(inclination(coarse[-1], fine[2 * len(rate)])) < 0.02


@pytest.mark.parametrize("aid", ["none", "airspeed", "paper-airspeed", "paper-airspeed-rate", "paper-filter"])
def test_one_sample_at_a_time_gives_what_a_log_gives(aid: str) -> None:
    log = wavy(n=500)
    assert log.airspeed is not None
    mixer = ComplementaryFilter(PAPER_GAINS, aid, gate=1e-3)
    rows = zip(*(each[:, None] for each in (log.t, log.omega_b, log.f_b, log.airspeed)), strict=True)
    steps = np.concatenate([mixer.run(AttitudeLog(*row)) for row in rows])
    assert steps == pytest.approx(ComplementaryFilter(PAPER_GAINS, aid, gate=1e-3).run(log), abs=1e-12)


def test_kernels_equal_their_plain_form() -> None:
    log = wavy(n=300)
    plain, compiled = np.zeros((2, 1), mixing_kernels.MIXER)
    plain[0].down[2] = compiled[0].down[2] = 1.0
    for w, f in zip(log.omega_b, log.f_b, strict=True):
        mixing_kernels.mix_vector.py_func(plain, 0.01, w, f, 0.1, 0.05)  # type: ignore[attr-defined]
        mixing_kernels.mix_vector(compiled, 0.01, w, f, 0.1, 0.05)
    for name in ("down", "correction"):
        assert plain[name] == pytest.approx(compiled[name], abs=1e-12)


def test_a_forward_speed_takes_the_turn_off() -> None:
    """A level turn at 50 m/s and 0.1 rad/s without bank, as a car's: the specific force leans by 27 deg."""
    n, rate, speed = 3000, 0.1, 50.0
    force = np.tile([0.0, rate * speed, -G], (n, 1))
    force[0] = [0.0, 0.0, -G]
    log = AttitudeLog(np.arange(n) * 0.01, np.tile([0.0, 0.0, rate], (n, 1)), force, np.full(n, speed))
    level = np.array([0.0, 0.0, 1.0])
    assert np.degrees(inclination(ComplementaryFilter().run(log)[-1], level)) > 15
    assert np.degrees(inclination(ComplementaryFilter(aid="airspeed").run(log)[-1], level)) < 0.2


def test_a_changing_speed_is_taken_off_by_the_whole_of_equation_9() -> None:
    """A car brakes by 2 m/s2 for 15 s: forward speed alone (10) takes it for a pitch, (9) takes du/dt off."""
    n, brake = 1500, 2.0
    t = np.arange(n) * 0.01
    force = np.tile([-brake, 0.0, -G], (n, 1))
    force[0] = [0.0, 0.0, -G]
    log = AttitudeLog(t, np.zeros((n, 3)), force, 40.0 - brake * t)
    aids = ("paper-airspeed", "paper-airspeed-rate")
    wrong = {aid: abs(ComplementaryFilter(aid=aid).run(log)[-1, 1]) for aid in aids}
    assert np.degrees(wrong["paper-airspeed"]) > 5
    lag = 0.3 * brake  # m/s, of the smoothed speed
    assert wrong["paper-airspeed-rate"] < PAPER_GAINS.k1 * lag / G


@pytest.mark.parametrize("knows_heading", [True, False])
def test_a_gnss_velocity_takes_a_climbing_turn_off_that_speeds_up(knows_heading: bool) -> None:
    """At 40 m/s and more, 0.1 rad/s, climbing by 3 m/s, nose along the path; banked as the turn is, then level."""
    n, turn, gain, climb = 4000, 0.1, 0.5, 3.0
    t = np.arange(n) * 0.01
    speed, course = 40.0 + gain * t, turn * t
    north, east = np.cos(course), np.sin(course)
    velocity = np.stack([speed * north, speed * east, np.full(n, -climb)], axis=1)
    roll, pitch = np.arctan(speed * turn / G), np.arctan(climb / speed)
    acceleration = np.stack([
        gain * north - speed * turn * east, gain * east + speed * turn * north, np.full(n, -G)
    ], axis=1)  # fmt: skip
    C_nb = np.stack([
        Rotation.from_euler("ZYX", angles).as_matrix() for angles in zip(course, pitch, roll, strict=True)
    ])  # fmt: skip
    step = np.swapaxes(C_nb[:-1], 1, 2) @ C_nb[1:]
    rate = np.vstack([np.zeros(3), Rotation.from_matrix(step).as_rotvec() / 0.01])
    velocity[np.arange(n) % 20 > 0] = np.nan  # 5 Hz
    log = AttitudeLog(
        t, rate, np.einsum("nji,nj->ni", C_nb, acceleration), velocity=velocity,
        heading=course if knows_heading else None,
    )  # fmt: skip
    found = ComplementaryFilter(ComplementaryGains.of_time_constant(3.0), "paper-gnss").run(log)[2500:]
    assert np.degrees(np.abs(found - np.stack([roll, pitch], axis=1)[2500:])).max() < 0.1
    alone = ComplementaryFilter(ComplementaryGains.of_time_constant(3.0)).run(log)
    assert np.degrees(inclination(alone, down_of(roll, pitch))).max() > 5


def shaken(size: float) -> AttitudeLog:
    """A rest whose gyros are noisy and whose accelerometers are shaken by white noise of ``size`` [m/s2]."""
    log, rng = paper_bench(4, 9, seconds=300.0), np.random.default_rng(1)
    force = log.f_b + size * rng.standard_normal(log.f_b.shape)
    rate = log.omega_b + 0.02 * rng.standard_normal(log.omega_b.shape)
    return AttitudeLog(log.t, rate, force, roll=log.roll, pitch=log.pitch, scored=log.scored)


def test_more_shaking_asks_for_a_longer_time_constant() -> None:
    grid = grid_of_taus(tuple(np.geomspace(0.5, 100, 9)))
    calm, rough = (tune(shaken(size), "none", grid) for size in (0.02, 5.0))
    assert grid[rough.best].k1 < 0.5 * grid[calm.best].k1
    assert not rough.at_edge
    assert rough.by_fold.shape == (9, FOLDS)


def test_the_held_out_error_is_no_smaller_than_the_best_could_be() -> None:
    found = tune(shaken(2.0), "none", grid_of_taus())
    assert found.held_out >= np.sqrt(np.mean(found.by_fold.min(axis=0) ** 2)) - 1e-12
    assert found.held_out >= found.rms[found.best] - 1e-12


def test_without_truth_nothing_is_chosen() -> None:
    log = paper_bench(1, 1, seconds=5.0)
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE, "roll_rad"):
        tune(AttitudeLog(log.t, log.omega_b, log.f_b), "none", [ComplementaryGains(0.1, 0.1)])


def test_a_minute_after_its_start_the_filter_with_airspeed_answers_by_its_own_gain() -> None:
    """Not by that of its first seconds, a running mean: a step of roll as the accelerometers have it."""
    dt, n, at, step = 0.01, 9000, 6000, 0.01
    force = np.tile([0.0, 0.0, -G], (n, 1))
    force[at:] = -G * down_of(np.array(step), np.array(0.0))
    log = AttitudeLog(np.arange(n) * dt, np.zeros((n, 3)), force, np.zeros(n))
    roll = roll_pitch_of(ComplementaryFilter(aid="airspeed", gains=PAPER_GAINS).run(log))[0][at:]
    k1, k2 = PAPER_GAINS.k1, PAPER_GAINS.k2
    t = dt * np.arange(1.0, n - at + 1)
    expected = lsim(([k1, k1 * k2], [1, k1, k1 * k2]), np.full(len(t), step), t)[1]
    assert roll == pytest.approx(expected, abs=0.02 * step)
