from dataclasses import replace

import numpy as np
import pytest

from procedures.attitude.attitude_estimate import AttitudeEstimate, estimate, estimate_both_directions
from procedures.attitude.attitude_log import AttitudeLog, earth_rate_ned, inclination
from procedures.attitude.kalman.kalman_filter import AttitudeKalmanFilter
from procedures.attitude.kalman.kalman_settings import AIDED_SETTINGS, UNAIDED_SETTINGS
from procedures.attitude.kalman.kalman_state import propagate
from procedures.attitude.kalman.strapdown_integration import align, integrate_sample
from procedures.frames import rotation
from procedures.geodesy import EARTH_RATE
from tests.drivers.simulated.flight import paper_bench, paper_flight
from tests.procedures.attitude.driving import G, driving


@pytest.mark.parametrize("aid", ["airspeed-filter", "gnss"])
def test_an_aid_holds_the_vertical_through_turns_and_braking_within_its_own_sigma(aid: str) -> None:
    log, down = driving()
    track = estimate(log, aid)
    error = inclination(track.down, down)
    late = log.t > 40
    assert np.degrees(np.sqrt(np.mean(error[late] ** 2))) < 0.3
    assert track.sigma is not None
    assert np.sqrt(np.mean((error[late] / track.sigma[late]) ** 2)) < 2
    assert track.gyro_bias_std is not None
    assert np.all(np.abs(track.gyro_bias - [2e-3, -1e-3, 3e-3]) < 4 * track.gyro_bias_std)
    assert np.degrees(inclination(estimate(log, "none").down, down)[late]).mean() > 1


@pytest.mark.parametrize("turn_s", [50.0, 300.0])
def test_the_papers_turn_at_200_m_s_stays_below_the_figure(turn_s: float) -> None:
    for seed in range(2):
        log = paper_flight(seed, turn_s)
        truth = log.true_down
        assert truth is not None
        error = np.degrees(inclination(estimate(log, "airspeed-filter").down, truth))
        assert error[log.t > 250].max() < 0.6


@pytest.mark.parametrize("position", [1, 6, 11])
def test_on_the_bench_every_position_reads_to_the_accelerometers_bias(position: int) -> None:
    log = paper_bench(3, position)
    truth = log.true_down
    assert truth is not None
    error = inclination(estimate(log, "none").down, truth)[log.t > 60]
    bias = np.linalg.norm(np.cross(log.f_b.mean(axis=0) / G, truth[0]))
    assert np.sqrt(np.mean(error**2)) < bias + np.radians(0.002)


def test_at_rest_sigma_is_what_the_error_is_where_the_accelerometers_are_known() -> None:
    """NEES over the twelve positions of two units: chi square of 2 x 24, within 4 of its own sigma."""
    ratios = list[float]()
    for seed in (3,):
        for position in range(1, 13):
            log = paper_bench(seed, position, seconds=70.0)
            track = estimate(log, "none", force_bias_std=140e-6 * G)
            assert log.true_down is not None
            assert track.sigma is not None
            ratios.append(float(inclination(track.down, log.true_down)[-1] / track.sigma[-1]))
    assert np.mean(np.square(ratios)) == pytest.approx(1.0, abs=4 / np.sqrt(len(ratios)))
    assert np.mean(np.square(ratios)) > 0.5


def test_rest_teaches_nothing_of_a_tilt_however_long_it_lasts() -> None:
    log = paper_bench(0, 1, seconds=300.0)
    sigma = estimate(log, "none").sigma
    assert sigma is not None
    assert (
        sigma[-1] > UNAIDED_SETTINGS.force_bias_std / G
    )  # two axes of it, less what could be an error of the start


@pytest.mark.parametrize("late_s", [0.2])
def test_a_late_velocity_counts_at_its_own_moment(late_s: float) -> None:
    log, down = driving()
    assert log.velocity is not None
    rows = round(late_s / 0.01)
    late = replace(log, velocity=np.vstack([np.full((rows, 3), np.nan), log.velocity[:-rows]]))

    def error(log: AttitudeLog, **specified: float) -> float:
        off = inclination(estimate(log, "gnss", **specified).down, down)  # type: ignore[arg-type]
        return float(np.degrees(np.sqrt(np.mean(off[log.t > 40] ** 2))))

    at_once, specified = error(log), error(late, fix_latency=late_s)
    assert specified < 1.3 * at_once + 0.02
    assert error(late) > 2 * specified


def test_one_sample_at_a_time_gives_what_a_log_gives() -> None:
    log, _ = driving(seconds=20.0)
    assert log.airspeed is not None
    assert log.velocity is not None
    for aid in ("none", "airspeed-filter", "gnss"):
        online, whole = AttitudeKalmanFilter(aid), AttitudeKalmanFilter(aid)
        out = whole.run(log)
        for row in zip(log.t, log.omega_b, log.f_b, log.airspeed, log.velocity, strict=True):
            online.step(*row)
        assert online.down == pytest.approx(out[-1, :3], abs=1e-9)
        assert online.sigma == pytest.approx(out[-1, 3], rel=1e-6)


def test_a_log_in_pieces_gives_what_it_gives_whole() -> None:
    log, _ = driving(seconds=20.0)
    whole, pieces = AttitudeKalmanFilter(), AttitudeKalmanFilter()
    whole.run(log)
    for part in (slice(0, 700), slice(700, None)):
        pieces.run(AttitudeLog(log.t[part], log.omega_b[part], log.f_b[part]))
    assert pieces.down == pytest.approx(whole.down, abs=1e-9)


def test_rest_is_denied_by_a_speed_and_teaches_the_bias_of_yaw() -> None:
    n = 3000
    rate = np.tile([0.0, 0.0, 0.004], (n, 1)) + 1e-4 * np.random.default_rng(1).standard_normal((n, 3))
    force = np.tile([0.0, 0.0, -G], (n, 1))
    for speed, at_rest in ((0.0, True), (30.0, False)):
        kept = AttitudeKalmanFilter("airspeed-filter")
        kept.run(AttitudeLog(np.arange(n) * 0.01, rate, force, np.full(n, speed)))
        assert kept.at_rest == at_rest
        bias, std = kept.gyro_bias
        assert (std[2] < 1e-3) == at_rest
        if at_rest:
            assert bias[2] == pytest.approx(0.004, abs=4 * std[2])


def at_rest_in_coarse_counts(fix_hz: int | None) -> AttitudeLog:
    """Ninety seconds on a bench at 50 Hz: a count of 1/1020 g s is 0.05 g in one sample; fixes of 5 cm/s."""
    rng = np.random.default_rng(8)
    n, dt, count = 4500, 0.02, G / 1020
    true = np.cumsum(np.tile([0.05, -0.08, -G], (n, 1)) * dt + 6e-5 * rng.standard_normal((n, 3)), axis=0)
    force = np.diff(np.floor(true / count), axis=0, prepend=0.0) * count / dt
    velocity = np.full((n, 3), np.nan)
    if fix_hz is not None:
        velocity[:: round(1 / dt / fix_hz)] = 0.0
        velocity += 0.05 * rng.standard_normal((n, 3))
    return AttitudeLog(np.arange(n) * dt, 2e-4 * rng.standard_normal((n, 3)), force, velocity=velocity)


@pytest.mark.parametrize("fix_hz", [10, None])
def test_fixes_that_cut_the_updates_of_coarse_counts_deny_no_rest(fix_hz: int | None) -> None:
    log = at_rest_in_coarse_counts(fix_hz)
    assert log.velocity is not None
    kept = AttitudeKalmanFilter("gnss", AIDED_SETTINGS._replace(nominal_s=0.02))
    resting = list[bool]()
    for t, rate, force, velocity in zip(log.t, log.omega_b, log.f_b, log.velocity, strict=True):
        kept.step(t, rate, force, velocity=velocity)
        resting.append(kept.at_rest)
    assert np.mean(resting) > 0.95


def test_a_gap_widens_sigma_and_a_long_one_restarts() -> None:
    log = paper_bench(1, 9, seconds=40.0)
    for seconds, wider in ((2.0, 1.2), (60.0, 5.0)):
        late = log.t > 20
        track = estimate(replace(log, t=log.t + seconds * late), "none")
        assert track.sigma is not None
        first = int(np.argmax(late))
        assert track.sigma[first + 5] > wider * track.sigma[first - 1]
        assert np.degrees(inclination(track.down, log.true_down)[-1]) < 0.05  # type: ignore[arg-type]


def test_saturated_rates_are_hardly_believed() -> None:
    log, down = driving()
    rate = log.omega_b.copy()
    rate[6000:6100] = np.clip(rate[6000:6100] + np.array([4.0, 0, 0]), -2.0, 2.0)  # a shock beyond the range
    track = estimate(replace(log, omega_b=rate), "airspeed-filter")
    assert any("clipped at 114.6 deg/s, 100 rows" in reported for reported in track.warnings)
    assert track.sigma is not None
    assert track.sigma[6110] > 5 * track.sigma[5990]
    assert np.degrees(inclination(track.down, down)[-1]) < 2


@pytest.mark.parametrize("known", [True, False])
def test_the_earths_rate_is_taken_off_with_latitude_and_heading(known: bool) -> None:
    """Truth at rest in a fast gyro's eyes: what it reads is the Earth, and no bias of the gyro."""
    heading, latitude, n = 0.7, 0.8, 60000
    C_bn = rotation(np.array([0.0, 0.0, -heading]))
    rate = np.tile(C_bn @ earth_rate_ned(latitude), (n, 1))
    log = AttitudeLog(
        np.arange(n) * 0.01, rate, np.tile([0.0, 0.0, -G], (n, 1)), np.zeros(n), heading=np.full(n, heading)
    )
    track = estimate(log, "airspeed-filter", latitude=latitude if known else None)
    assert track.gyro_bias_std is not None
    size = float(np.linalg.norm(track.gyro_bias))
    assert size < 0.05 * EARTH_RATE if known else size == pytest.approx(EARTH_RATE, rel=0.05)


@pytest.mark.parametrize(("aid", "from_row"), [("airspeed-filter", 1700), ("gnss", 1700)])
def test_an_aid_that_begins_under_way_is_no_outlier(aid: str, from_row: int) -> None:
    log, down = driving()
    assert log.airspeed is not None
    assert log.velocity is not None
    speed, velocity, heading = log.airspeed.copy(), log.velocity.copy(), np.full(len(log.t), np.nan)
    speed[:from_row] = velocity[:from_row] = np.nan
    heading[0] = 1.0
    late = replace(log, airspeed=speed, velocity=velocity, heading=heading if aid == "gnss" else None)
    error = np.degrees(inclination(estimate(late, aid).down, down))
    assert error[1500:1700].max() > 5  # what was taken for rest was 3 m/s2 of starting
    assert np.sqrt(np.mean(error[log.t > 60] ** 2)) < 0.5


def test_kernels_equal_their_plain_form() -> None:
    log, _ = driving(seconds=2.0)
    plain, compiled = AttitudeKalmanFilter(), AttitudeKalmanFilter()
    for kept, take, carry in (
        (plain, integrate_sample.py_func, propagate.py_func),  # type: ignore[attr-defined]
        (compiled, integrate_sample, propagate),
    ):
        s, c = kept.state, kept.settings
        align(s, c, np.array([0.1, 0.2, -9.8]), 3.0)
        for w, f in zip(log.omega_b[:20], log.f_b[:20], strict=True):
            take(s, c, 0.01, w, f, 3.0)
        carry(s, c)
    assert plain.state.C_nb == pytest.approx(compiled.state.C_nb, abs=1e-13)
    assert plain.state.P == pytest.approx(compiled.state.P, abs=1e-13)
    assert np.linalg.eigvalsh(plain.state.P).min() > -1e-12


def rms_deg(down: np.ndarray, truth: np.ndarray, rows: np.ndarray | slice = slice(None)) -> float:
    return float(np.degrees(np.sqrt(np.mean(inclination(down, truth)[rows] ** 2))))


@pytest.mark.parametrize("aid", ["airspeed-filter", "gnss"])
def test_both_directions_are_better_than_one_and_most_at_the_start(aid: str) -> None:
    log, down = driving()
    online, both = estimate(log, aid), estimate_both_directions(log, aid)
    assert rms_deg(both.down, down) < 0.7 * rms_deg(online.down, down)
    assert rms_deg(both.down, down, log.t < 30) < 0.5 * rms_deg(online.down, down, log.t < 30)
    assert both.sigma is not None
    assert online.sigma is not None
    assert np.median(both.sigma / online.sigma) < 0.98
    assert np.all(both.sigma < 1.001 * online.sigma)
    assert both.down[-1] == pytest.approx(online.down[-1])  # nothing comes after the last row


@pytest.mark.parametrize("late_s", [0.0, 0.2])
def test_late_fixes_count_at_their_own_moment_in_both_directions(late_s: float) -> None:
    log, down = driving()
    assert log.velocity is not None
    rows = round(late_s / 0.01)
    late = replace(log, velocity=np.vstack([np.full((rows, 3), np.nan), log.velocity[: len(log.t) - rows]]))
    assert rms_deg(estimate_both_directions(late, "gnss", fix_latency=late_s).down, down) < 0.06
    if late_s:
        assert rms_deg(estimate_both_directions(late, "gnss").down, down) > 0.06


def test_what_both_share_stays_in_sigma() -> None:
    """At rest both see the same accelerometers: NEES over twelve positions, chi square of 24."""
    tracks = list[tuple[AttitudeLog, AttitudeEstimate]]()
    for position in range(1, 13):
        log = paper_bench(5, position, seconds=70.0)
        tracks.append((log, estimate_both_directions(log, "none", force_bias_std=140e-6 * G)))
    nees = list[float]()
    for log, track in tracks:
        assert log.true_down is not None
        assert track.sigma is not None
        nees.append(float((inclination(track.down, log.true_down)[3500] / track.sigma[3500]) ** 2))
    assert np.mean(nees) == pytest.approx(1.0, abs=4 / np.sqrt(len(nees)))
    assert np.mean(nees) > 0.4
