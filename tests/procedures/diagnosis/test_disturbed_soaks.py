"""Knocks and wrong rows of a soak are cut out and said; steps, noise's own bursts and long states are left in."""

import numpy as np
import pytest

from procedures.anomalies.disturbed_soaks import QuietSoaks, without_shocks
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries

RATE, SECONDS = 50, 900
SIGMA = 0.01  # g and deg/s a sample
N = RATE * SECONDS
AT = 20000  # the row where it happens, at 400 s


def soak(accel: FloatArray, gyro: FloatArray) -> Campaign:
    series = RateSeries(
        (np.arange(N) + 1) / RATE, SIGMA * gyro, SIGMA * accel, np.full(N, np.nan), 1 / RATE, np.array([0]), {}
    )
    return Campaign(
        "m", "s", False, Site(0.8, 9.8, 0.01), (), (), soaks=(SoakRecord("log.csv", 0, None, series),),
        nominal_scale={"accelerometer": 1.0, "gyroscope": 1.0},
    )  # fmt: skip


def noise(seed: int) -> tuple[FloatArray, FloatArray]:
    drawn = np.random.default_rng(seed).standard_normal((2, N, 3))
    return drawn[0], drawn[1]


def lost(found: QuietSoaks) -> int:
    return N - len(found.campaigns[0].soaks[0].series)


def test_a_shock_of_a_second_is_cut_and_reported() -> None:
    accel, gyro = noise(1)
    accel[AT : AT + RATE] += 20 * np.random.default_rng(2).standard_normal((RATE, 3))
    found = without_shocks([soak(accel, gyro)])
    (finding,) = found.findings
    assert (finding.effect, finding.confidence, finding.unit) == ("disturbance.dwell", "established", "g")
    assert float(str(finding.where["from_s"])) <= 401.0
    assert float(str(finding.where["to_s"])) >= 400.9
    assert RATE <= lost(found) <= 4 * RATE
    assert finding.value == pytest.approx(20 * SIGMA * np.sqrt(2) * np.ones(3), rel=0.4)  # a sine of its rms


@pytest.mark.parametrize("size", [25.0, 8000.0])
def test_a_wrong_row_is_named_with_its_channel_time_and_size(size: float) -> None:
    accel, gyro = noise(3)
    gyro[AT, 1] += size
    found = without_shocks([soak(accel, gyro)])
    (finding,) = found.findings
    assert finding.fault == "wrong row"
    assert (finding.where["channel"], finding.where["at_s"]) == ("gy", pytest.approx(400.02))
    assert finding.unit == "deg/h"
    assert finding.value[1] == pytest.approx(3600 * SIGMA * size, abs=4 * 3600 * SIGMA)
    assert np.max(np.abs(finding.value[[0, 2]])) < 4 * 3600 * SIGMA
    assert 1 <= lost(found) <= 2 * RATE


def test_what_one_sensor_alone_does_for_a_while_may_be_its_own() -> None:
    accel, gyro = noise(5)
    gyro[AT : AT + 3 * RATE, 2] += 6.0
    (finding,) = without_shocks([soak(accel, gyro)]).findings
    assert finding.confidence == "possible"
    assert finding.aliases == ("gyroscope.jump",)


@pytest.mark.parametrize("seed", [0])
@pytest.mark.parametrize("kind", ["white", "student", "bursts", "step", "levels", "state", "walk"])
def test_noise_steps_and_states_are_left_in(kind: str, seed: int) -> None:
    """Student's t of 3 degrees of freedom; bursts of 10 s; a step; two levels; a fan for 5 minutes; a walk."""
    rng = np.random.default_rng(seed)
    accel, gyro = noise(10 + seed)
    if kind == "student":
        gyro, accel = rng.standard_t(3, (2, N, 3))
    elif kind == "bursts":
        gyro *= np.repeat(np.where(rng.random((N // 500, 1)) < 0.3, 3.0, 1.0), 500, axis=0)
    elif kind == "step":
        gyro[AT:, 1] += 10.0
    elif kind == "levels":
        gyro[:, 0] += 4.0 * (np.cumsum(rng.random(N) < 2e-4) % 2)
    elif kind == "state":
        accel[AT : AT + 300 * RATE] *= 4.0
    elif kind == "walk":
        gyro += 0.02 * np.cumsum(rng.standard_normal((N, 3)), axis=0)
    found = without_shocks([soak(accel, gyro)])
    assert not found.findings
    assert not lost(found)


def test_a_channel_that_is_dead_or_coarse_is_no_disturbance() -> None:
    accel, gyro = noise(6)
    accel[:, 0], gyro[:, 2] = 0.0, np.round(0.2 * gyro[:, 2])
    found = without_shocks([soak(accel, gyro)])
    assert not found.findings


def test_a_channel_that_stands_still_for_a_while_is_cut_and_reported() -> None:
    accel, gyro = noise(7)
    gyro[AT : AT + 60 * RATE, 1] = gyro[AT, 1]
    found = without_shocks([soak(accel, gyro)])
    (finding,) = found.findings
    assert finding.fault == "frozen"
    assert (finding.where["channel"], finding.where["from_s"]) == ("gy", pytest.approx(400.02))
    assert finding.where["to_s"] == pytest.approx(460.0)
    others = np.delete(gyro[:, 1], np.s_[AT : AT + 60 * RATE])  # in one unit with the value that it stood at
    assert finding.std[0] / finding.value[0] == pytest.approx(others.std() / gyro[AT, 1], rel=1e-6)
    assert lost(found) == 60 * RATE
    gyro[AT:, 1] = gyro[AT, 1]  # for good: it is dead, which is said; it is left out elsewhere
    found = without_shocks([soak(accel, gyro)])
    assert [each.where["to_s"] for each in found.findings] == [pytest.approx(900.0)]
    assert not lost(found)


def test_noise_that_grows_for_good_is_reported_with_the_moment_and_left_in() -> None:
    accel, gyro = noise(11)
    gyro[AT:, 2] *= 3.0
    found = without_shocks([soak(accel, gyro)])
    (finding,) = found.findings
    assert (finding.confidence, finding.aliases) == ("possible", ("gyroscope.noise",))
    assert finding.where["from_s"] == pytest.approx(400.0, abs=10.0)
    assert finding.value[0] == pytest.approx(2 * 3600 * SIGMA, rel=0.05)
    assert not lost(found)


def test_a_saturated_output_is_reported() -> None:
    accel, gyro = noise(12)
    accel[:, 2] = np.minimum(accel[:, 2], 1.5)
    gyro[:, 0] = np.round(3 * gyro[:, 0])  # coarse, which is no end
    (finding,) = without_shocks([soak(accel, gyro)]).findings
    assert finding.where["channel"] == "az"
    assert finding.shape.startswith("6.")
    assert finding.value[0] == pytest.approx(1.5 * SIGMA)


# Short soaks at 10 Hz


SMALL_PERIOD, SMALL_N, SMALL_AT = 0.1, 6000, 2500
UNITS = {"accelerometer": 2.0, "gyroscope": 4.0}  # outputs a g and a deg/s


def drawn(seed: int) -> tuple[FloatArray, FloatArray]:
    both = np.random.default_rng(seed).standard_normal((2, SMALL_N, 3))
    return both[0], both[1]


def small_soak(accel: FloatArray, gyro: FloatArray, name: str = "log.csv") -> SoakRecord:
    t = SMALL_PERIOD * (np.arange(len(gyro)) + 1)
    return SoakRecord(name, 0, None, RateSeries(t, gyro, accel, np.full(len(gyro), 25.0), SMALL_PERIOD))


def campaign(*soaks: SoakRecord) -> Campaign:
    return Campaign("m", "s", False, Site(0.8, 9.8, 0.01), (), (), soaks=soaks, nominal_scale=UNITS)


def kept(found: QuietSoaks) -> list[list[int]]:
    return [[len(each.series) for each in one.soaks] for one in found.campaigns]


def shaken(seconds: float, times: float, axes: tuple[int, ...] = (0, 1, 2), seed: int = 1) -> SoakRecord:
    accel, gyro = drawn(seed)
    accel[SMALL_AT : SMALL_AT + round(seconds / SMALL_PERIOD), axes] *= times
    return small_soak(accel, gyro)


def test_a_wrong_row_is_cut_out_of_its_own_soak_of_its_own_campaign() -> None:
    accel, gyro = drawn(2)
    gyro[SMALL_AT, 1] = 100.0
    quiet = small_soak(*drawn(3), "quiet.csv")
    found = without_shocks([campaign(quiet), campaign(quiet, small_soak(accel, gyro, "knocked.csv"))])
    (finding,) = found.findings
    assert (finding.where["file"], finding.where["channel"]) == ("knocked.csv", "gy")
    assert finding.where["at_s"] == pytest.approx(SMALL_PERIOD * (SMALL_AT + 1))
    assert kept(found) == [[SMALL_N], [SMALL_N, SMALL_N - 1]]
    assert SMALL_PERIOD * (SMALL_AT + 1) not in found.campaigns[1].soaks[1].series.t
    assert [each.name for each in found.campaigns[1].soaks] == ["quiet.csv", "knocked.csv"]
    assert found.campaigns[0].rests == ()


@pytest.mark.parametrize(("triad", "unit", "per"), [("accelerometer", "g", 2.0), ("gyroscope", "deg/h", 4 / 3600)])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_wrong_row_is_as_large_as_its_scale_factor_says(triad: str, unit: str, per: float, sign: int) -> None:
    accel, gyro = drawn(4)
    (accel if triad == "accelerometer" else gyro)[SMALL_AT, 2] = sign * 1000.0
    (finding,) = without_shocks([campaign(small_soak(accel, gyro))]).findings
    assert (finding.unit, finding.fault, finding.coefficients) == (unit, "wrong row", ("x", "y", "z"))
    assert finding.value[2] == pytest.approx(sign * 1000.0 / per, rel=1e-2)
    assert finding.std == pytest.approx(np.ones(3) / per, rel=0.25)


@pytest.mark.parametrize(("seconds", "is_cut"), [(20.0, True), (45.0, False)])
def test_a_shock_is_cut_and_what_lasts_longer_is_a_state_that_stays(seconds: float, is_cut: bool) -> None:
    found = without_shocks([campaign(shaken(seconds, 30.0))])
    (finding,) = found.findings
    assert (finding.effect, finding.unit) == ("disturbance.dwell", "g")
    assert finding.probability > 0.9  # a thirteenth of the soak: noise in bursts is the other explanation
    assert "others" not in finding.where
    assert (kept(found)[0][0] < SMALL_N - 9 * seconds) == is_cut
    assert (kept(found)[0][0] == SMALL_N) == (not is_cut)
