"""Knocks, wrong rows and states of short soaks at 10 Hz: what is cut, what is named, and in which unit."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, Site, SoakRecord, TurnRecord
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.diagnosis import disturbed_soaks
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


def test_counts_of_a_wrong_row_are_those_of_a_sample() -> None:
    accel, gyro = (np.round(300 * each).astype(np.int64) for each in drawn(5))
    accel[AT, 0] = 100_000
    t = PERIOD * (np.arange(N) + 1)
    series = CountSeries(t, gyro, accel, np.full(N, 25.0), PERIOD)
    one = campaign(SoakRecord("log.csv", 0, None, series))
    (finding,) = without_knocks([replace(one, counts=True)]).findings
    assert (finding.where["channel"], finding.unit) == ("ax", "g")
    assert finding.value[0] == pytest.approx(100_000 / (2.0 * PERIOD), rel=1e-2)


def test_a_channel_that_never_moves_is_no_part_of_a_wrong_row() -> None:
    accel, gyro = drawn(6)
    gyro[AT, 0], gyro[:, 1] = -500.0, 0.0
    (finding,) = without_knocks([campaign(soak(accel, gyro))]).findings
    assert finding.coefficients == ("x", "z")
    assert finding.value[0] == pytest.approx(-500.0 * 900, rel=0.01)
    assert len(finding.value) == len(finding.std) == 2


@pytest.mark.parametrize(("rows", "named", "others"), [(3, 3, None), (4, 1, 3)])
def test_up_to_three_wrong_rows_are_named_each(rows: int, named: int, others: int | None) -> None:
    accel, gyro = drawn(7)
    at = 700 + 1500 * np.arange(rows)
    gyro[at, 2] = 100.0 + 100.0 * np.arange(rows)
    found = without_knocks([campaign(soak(accel, gyro))])
    assert len(found.findings) == named
    assert {each.where.get("others") for each in found.findings} == {others}
    assert kept(found) == [[N - rows]]
    surest = found.findings[0]
    assert surest.where["at_s"] == pytest.approx(PERIOD * (at[-1] + 1))
    assert surest.log_p == min(each.log_p for each in found.findings)


@pytest.mark.parametrize(("seconds", "is_cut"), [(20.0, True), (45.0, False)])
def test_a_knock_is_cut_and_what_lasts_longer_is_a_state_that_stays(seconds: float, is_cut: bool) -> None:
    found = without_knocks([campaign(shaken(seconds, 30.0))])
    (finding,) = found.findings
    assert (finding.effect, finding.confidence, finding.unit) == ("disturbance.dwell", "established", "g")
    assert "others" not in finding.where
    assert (kept(found)[0][0] < N - 9 * seconds) == is_cut
    assert (kept(found)[0][0] == N) == (not is_cut)


@pytest.mark.parametrize(("seconds", "alias"), [(10.0, "accelerometer.jump"), (45.0, "accelerometer.noise")])
def test_of_one_sensor_alone_it_may_be_its_own(seconds: float, alias: str) -> None:
    (finding,) = without_knocks([campaign(shaken(seconds, 30.0, (1,)))]).findings
    assert (finding.confidence, finding.aliases) == ("ambiguous", (alias,))


@pytest.mark.parametrize(("seconds", "alias"), [(10.0, "gyroscope.jump"), (45.0, "gyroscope.noise")])
def test_and_of_a_gyroscope_alone_too(seconds: float, alias: str) -> None:
    accel, gyro = drawn(8)
    gyro[AT : AT + round(seconds / PERIOD), 2] *= 30.0
    (finding,) = without_knocks([campaign(soak(accel, gyro))]).findings
    assert (finding.confidence, finding.aliases, finding.unit) == ("ambiguous", (alias,), "deg/h")


@pytest.mark.parametrize(("rows", "is_cut"), [(3.0, True), (2.9, False)])
def test_what_is_cut_is_a_share_of_a_soak_at_most(
    monkeypatch: pytest.MonkeyPatch, rows: float, is_cut: bool
) -> None:
    """Three wrong rows are as many as the share allows, and one too many for less."""
    monkeypatch.setattr(disturbed_soaks, "MAX_CUT_SHARE", rows / N)
    accel, gyro = drawn(7)
    gyro[[700, 2200, 3700], 2] = 100.0, 200.0, 300.0
    found = without_knocks([campaign(soak(accel, gyro))])
    assert len(found.findings) == (3 if is_cut else 1)
    assert {each.where.get("others") for each in found.findings} == {None if is_cut else 2}
    assert kept(found) == [[N - 3 if is_cut else N]]
    if not is_cut:
        assert (
            float(str(found.findings[0].where["from_s"])) <= 370.1 <= float(str(found.findings[0].where["to_s"]))
        )


def test_beside_knocks_that_are_cut_a_state_is_said_by_itself() -> None:
    accel, gyro = drawn(10)
    accel[1000:1100] *= 40.0
    accel[3000:3500] *= 20.0
    found = without_knocks([campaign(soak(accel, gyro))])
    short, long = found.findings
    assert float(str(short.where["to_s"])) < 120 < 290 < float(str(long.where["from_s"]))
    assert "others" not in {**short.where, **long.where}
    assert N - 400 < kept(found)[0][0] <= N - 100


def test_a_jump_of_the_level_is_neither_cut_nor_said() -> None:
    accel, gyro = drawn(11)
    gyro[AT:, 1] += 12.0
    found = without_knocks([campaign(soak(accel, gyro))])
    assert (found.findings, kept(found)) == ((), [[N]])
    assert len(found.tests) == 1


def test_of_two_wrong_rows_half_a_second_apart_the_larger_is_told_and_all_between_is_cut() -> None:
    accel, gyro = drawn(12)
    gyro[AT, 1], gyro[AT + 5, 0] = 60.0, -400.0
    found = without_knocks([campaign(soak(accel, gyro))])
    (finding,) = found.findings
    assert finding.where["channel"] == "gx"
    assert finding.where["at_s"] == pytest.approx(PERIOD * (AT + 6))
    assert finding.value[0] == pytest.approx(-400.0 * 900, rel=0.02)
    assert kept(found) == [[N - 6]]


def test_what_two_sensors_show_for_long_is_not_their_own() -> None:
    (finding,) = without_knocks([campaign(shaken(45.0, 30.0, (0, 2)))]).findings
    assert finding.confidence == "established"


def test_of_two_knocks_that_are_too_many_the_other_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disturbed_soaks, "MAX_CUT_SHARE", 1.9 / N)
    accel, gyro = drawn(13)
    gyro[[900, 4200], 0] = 300.0, 100.0
    (finding,) = without_knocks([campaign(soak(accel, gyro))]).findings
    assert finding.where["others"] == 1


def test_dwells_and_turns_beside_a_soak_are_not_looked_at_and_stay() -> None:
    accel, gyro = drawn(14)
    accel[AT] = 500.0
    quiet, shaky = soak(*drawn(15)), soak(accel, gyro).series
    dwell, turn = DwellRecord("dwell", 1, shaky), TurnRecord("turn", "x", "+", 1, 1, shaky)
    found = without_knocks([replace(campaign(quiet), dwells=(dwell,), turns=(turn,), nominal_scale={})])
    assert (found.findings, kept(found)) == ((), [[N]])
    assert (found.campaigns[0].dwells, found.campaigns[0].turns) == ((dwell,), (turn,))


def test_the_scale_factor_of_a_soak_is_not_taken_from_a_dwell() -> None:
    accel, gyro = drawn(16)
    accel[AT, 0] = 500.0
    t = PERIOD * np.arange(1, 101)
    still = RateSeries(t, np.full((100, 3), 7.0), np.full((100, 3), 7.0), np.full(100, 25.0), PERIOD)
    one = replace(campaign(soak(accel, gyro)), dwells=(DwellRecord("dwell", 1, still),))
    (finding,) = without_knocks([one]).findings
    assert finding.value[0] == pytest.approx(500.0 / 2.0, rel=1e-2)
