"""Knocks, wrong rows and states of short soaks at 10 Hz: what is cut, what is named, and in which unit."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.disturbed_soaks import QuietSoaks, without_knocks

PERIOD, N, AT = 0.1, 6000, 2500
UNITS = {"accelerometer": 2.0, "gyroscope": 4.0}  # outputs a g and a deg/s


def drawn(seed: int) -> tuple[FloatArray, FloatArray]:
    both = np.random.default_rng(seed).standard_normal((2, N, 3))
    return both[0], both[1]


def soak(accel: FloatArray, gyro: FloatArray, name: str = "log.csv") -> SoakRecord:
    t = PERIOD * (np.arange(len(gyro)) + 1)
    return SoakRecord(name, 0, None, RateSeries(t, gyro, accel, np.full(len(gyro), 25.0), PERIOD))


def campaign(*soaks: SoakRecord) -> Campaign:
    return Campaign("m", "s", False, Site(0.8, 9.8, 0.01), (), (), soaks=soaks, nominal_scale=UNITS)


def kept(found: QuietSoaks) -> list[list[int]]:
    return [[len(each.series) for each in one.soaks] for one in found.campaigns]


def shaken(seconds: float, times: float, axes: tuple[int, ...] = (0, 1, 2), seed: int = 1) -> SoakRecord:
    accel, gyro = drawn(seed)
    accel[AT : AT + round(seconds / PERIOD), axes] *= times
    return soak(accel, gyro)


def test_a_wrong_row_is_cut_out_of_its_own_soak_of_its_own_campaign() -> None:
    accel, gyro = drawn(2)
    gyro[AT, 1] = 100.0
    quiet = soak(*drawn(3), "quiet.csv")
    found = without_knocks([campaign(quiet), campaign(quiet, soak(accel, gyro, "knocked.csv"))])
    (finding,) = found.findings
    assert (finding.where["file"], finding.where["channel"]) == ("knocked.csv", "gy")
    assert finding.where["at_s"] == pytest.approx(PERIOD * (AT + 1))
    assert kept(found) == [[N], [N, N - 1]]
    assert PERIOD * (AT + 1) not in found.campaigns[1].soaks[1].series.t
    assert [each.name for each in found.campaigns[1].soaks] == ["quiet.csv", "knocked.csv"]
    assert found.campaigns[0].rests == ()


@pytest.mark.parametrize(("triad", "unit", "per"), [("accelerometer", "g", 2.0), ("gyroscope", "deg/h", 4 / 3600)])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_wrong_row_is_as_large_as_its_scale_factor_says(triad: str, unit: str, per: float, sign: int) -> None:
    accel, gyro = drawn(4)
    (accel if triad == "accelerometer" else gyro)[AT, 2] = sign * 1000.0
    (finding,) = without_knocks([campaign(soak(accel, gyro))]).findings
    assert (finding.unit, finding.shape, finding.coefficients) == (unit, "a wrong row", ("x", "y", "z"))
    assert finding.value[2] == pytest.approx(sign * 1000.0 / per, rel=1e-2)
    assert finding.std == pytest.approx(np.ones(3) / per, rel=0.25)


@pytest.mark.parametrize(("seconds", "is_cut"), [(20.0, True), (45.0, False)])
def test_a_knock_is_cut_and_what_lasts_longer_is_a_state_that_stays(seconds: float, is_cut: bool) -> None:
    found = without_knocks([campaign(shaken(seconds, 30.0))])
    (finding,) = found.findings
    assert (finding.effect, finding.confidence, finding.unit) == ("disturbance.dwell", "established", "g")
    assert "others" not in finding.where
    assert (kept(found)[0][0] < N - 9 * seconds) == is_cut
    assert (kept(found)[0][0] == N) == (not is_cut)
