"""Turntables in the diagnosis: simulated tables with effects planted, and the measured one of a real FOG."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, Fixture, RateTable, Site
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, Finding
from tests.paths import DATA

SITE = Site(0.7, 9.8, 1e-3)
RATES = np.concatenate((np.arange(0, 101, 5), -np.arange(0, 101, 5)))
SWEEPS, NOISE = 9, 2e-3  # deg/s
NONLINEAR = {"gyroscope.scale_nonlinearity", "gyroscope.sagnac_sine"}


def table(seed: int, cubic: float = 0.0, warm: float = 0.0, axis: str = "z", k: float = -2e4) -> RateTable:
    """Return a table of one sensor, bias 0.01 deg/s: cubic [ppm/(deg/s)^2], scale by temperature [ppm/K]."""
    rng = np.random.default_rng(seed)
    u = np.tile(RATES, SWEEPS)
    T = 40 + 10 * np.linspace(0, 1, len(u)) ** 0.7
    rate = (u + 0.01 + 1e-6 * cubic * u**3) * (1 + 1e-6 * warm * (T - 25)) + NOISE * rng.standard_normal(len(u))
    output = np.full((len(u), 3), np.nan)
    output[:, "xyz".index(axis)] = k * rate
    return RateTable(f"rates_{axis}.csv", axis, u, output, T)


def campaign(*tables: RateTable) -> Campaign:
    return Campaign("A", "1", False, SITE, (), (), rate_tables=tables)


def found(diagnosis: Diagnosis, *names: str) -> Finding:
    return next(each for each in diagnosis.findings if each.effect in names)


@pytest.mark.parametrize("k", [-2e4, 5.0])
def test_nonlinearity_then_temperature_come_out_within_their_own_sigma(k: float) -> None:
    errors = list[float]()
    for seed in range(2):
        diagnosis = diagnose([campaign(table(seed, cubic=-2.0, warm=-400.0, k=k))])
        assert [each.effect for each in diagnosis.findings][1:] == ["gyroscope.scale_temperature"]
        first, warm = found(diagnosis, *NONLINEAR), found(diagnosis, "gyroscope.scale_temperature")
        assert {first.effect, *first.aliases} == NONLINEAR
        assert (first.coefficients, warm.coefficients) == (("z",), ("z",))
        assert warm.confidence == "established"
        assert diagnosis.log_p > np.log(1e-3)
        errors.append(float((warm.value[0] + 400) / warm.std[0]))
        if first.effect == "gyroscope.scale_nonlinearity":
            errors.append(float((first.value[0] + 2.0) / first.std[0]))
    assert np.std(errors) < 1.6
    assert np.max(np.abs(errors)) < 4


def test_scale_factor_and_bias_of_the_turned_sensor_are_told_with_honest_sigmas() -> None:
    errors = list[tuple[float, float]]()
    for seed in range(5):
        diagnosis = diagnose([campaign(table(seed, warm=-400.0, k=-5.0))])
        (one,) = diagnosis.on_table
        assert one.axis == "z"
        assert one.scale_std < 1e-4 * abs(one.scale)
        errors.append(((one.scale + 5.0) / one.scale_std, (one.bias - 3600 * 0.01) / one.bias_std))
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert np.all((rms > 0.3) & (rms < 1.8)), rms


def test_a_sine_far_along_its_arc_is_no_cubic() -> None:
    plain, s = table(3), 5e-3  # rad/(deg/s): half a radian at the highest rate
    bent = np.sin(s * plain.reference) / s - plain.reference
    output = plain.output - 2e4 * bent[:, None]
    diagnosis = diagnose([campaign(replace(plain, output=output))])
    (sine,) = diagnosis.findings
    assert (sine.effect, sine.aliases, sine.confidence) == ("gyroscope.sagnac_sine", (), "established")
    assert abs(sine.value[0] - s) < 4 * sine.std[0]
    assert diagnosis.log_p > np.log(1e-3)


def test_tables_with_nothing_in_them_name_nothing() -> None:
    named = [diagnose([campaign(table(seed))]) for seed in range(5)]
    assert sum(bool(each.findings) for each in named) <= 1
    assert sum(each.verdict == "unexplained" for each in named) <= 1


def test_three_axes_and_a_turned_mounting_keep_their_sensors_apart() -> None:
    tables = [table(i, cubic=-2.0 if axis == "x" else 0.0, axis=axis) for i, axis in enumerate("xyz")]
    diagnosis = diagnose([campaign(*tables)])
    first = found(diagnosis, *NONLINEAR)
    assert first.coefficients == ("x", "y", "z")
    size, std = np.abs(first.value), first.std
    if first.effect == "gyroscope.sagnac_sine":  # what is fitted is its square
        size, std = size**2, (size + std) ** 2 - size**2
    assert size[0] > 20 * std[0]
    assert np.all(size[1:] < 4 * std[1:])
    turned = Fixture(C_sb=np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]))
    mounted = replace(campaign(replace(table(5, cubic=-2.0, axis="x"), axis="z")), fixture=turned)
    assert found(diagnose([mounted]), *NONLINEAR).coefficients == ("x",)


def test_a_scale_factor_that_lags_is_named_where_points_have_a_time() -> None:
    rng = np.random.default_rng(7)
    u = np.tile(RATES, SWEEPS)
    t = 16.0 * np.arange(len(u))
    T = 40 + 10 * np.sin(2 * np.pi * t / 3000)
    own, step = np.empty(len(t)), np.exp(-16 / 600)  # by the exact step of a straight line, from equilibrium
    own[0] = T[0]
    for i in range(1, len(t)):
        slope = (T[i] - T[i - 1]) / 16
        own[i] = T[i] - 600 * slope + step * (own[i - 1] - T[i - 1] + 600 * slope)
    rate = (u + 0.01) * (1 + 1e-6 * 60 * (own - 25)) + NOISE * rng.standard_normal(len(u))
    output = np.full((len(u), 3), np.nan)
    output[:, 2] = -2e4 * rate
    points = RateTable("rates.csv", "z", u, output, T, t)
    lag = diagnose([campaign(points)]).findings
    assert [(each.effect, each.confidence) for each in lag] == [("gyroscope.scale_temperature_lag", "established")]
    told = dict(zip(lag[0].coefficients, zip(lag[0].value, lag[0].std, strict=True), strict=True))
    for name, true in {"z": 60.0, "tau_s": 600.0}.items():
        value, std = told[name]
        assert abs(value - true) < 4 * std < 0.4 * true
    timeless = diagnose([campaign(replace(points, t=None))])
    assert all("lag" not in name for each in timeless.findings for name in (each.effect, *each.aliases))


def measured() -> Diagnosis:
    """Return the diagnosis of a real FOG's table, heated while it was turned."""
    folder = DATA / "measured/fog_rate_temperature"
    if not folder.is_dir():
        pytest.skip(f"no shared data at {DATA}: set STATION_DATA")
    points = np.genfromtxt(folder / "rates.csv", delimiter=",", names=True)
    output = np.full((len(points), 3), np.nan)
    output[:, 2] = points["gz"]
    return diagnose([campaign(RateTable("rates.csv", "z", points["rate_ref_deg_s"], output, points["temp_c"]))])


def test_the_measured_fog_is_nonlinear_then_warm_and_nothing_more() -> None:
    diagnosis = measured()
    assert [each.effect for each in diagnosis.findings][1:] == ["gyroscope.scale_temperature"]
    first, warm = diagnosis.findings
    assert warm.coefficients == ("z.1", "z.2")
    assert {first.effect, *first.aliases} == NONLINEAR
    assert (first.confidence, warm.confidence, diagnosis.verdict) == ("ambiguous", "established", "ambiguous")
    (error,) = diagnosis.errors
    ppm = 1e6 / np.degrees(2.639)
    assert 11_800 < error.before * ppm < 11_880
    assert 120 < error.after * ppm < 132
    assert error.held_out_after is not None
    assert 127 < error.held_out_after * ppm < 140
    assert np.radians(error.held_out_after) <= 3.6e-4
