"""What the sensors went through: means in bins, a parabola of temperature, attitudes and fields by hand."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.counts.sample_records import RateSeries
from procedures.effects.excitation import ExcitationStep
from procedures.evidence.excitation import Bins, NodeBuilder, StepNodes, attitude, equal_bins, on_face
from tests.procedures.diagnosis.planted import planted

FIELD = (1.0, 30.0, -40.0)  # uT
STEP = ExcitationStep("d", "dwell", 0, 1, "x_up")


def series(n: int, period: float = 0.5, begin: float = 100.0, temperature: FloatArray | None = None) -> RateSeries:
    t = begin + period * np.arange(n)
    return RateSeries(
        t, np.zeros((n, 3)), None, np.full(n, np.nan) if temperature is None else temperature, period
    )


def test_bins_are_of_whole_samples_and_hold_their_means() -> None:
    bins = equal_bins(series(10), 4)
    assert bins.edges.tolist() == [0, 2, 5, 8, 10]
    assert bins.mean(np.arange(10.0) ** 2).tolist() == [0.5, 29 / 3, 110 / 3, 72.5]
    assert bins.mean(np.outer(np.arange(10), [1.0, -2.0])).tolist() == [[0.5, -1], [3, -6], [6, -12], [8.5, -17]]
    assert bins.seconds.tolist() == [1.0, 1.5, 1.5, 1.0]
    assert bins.middle.tolist() == [100.0, 101.25, 102.75, 104.0]  # a sample's mean is of the period before it
    assert equal_bins(series(3), 96).edges.tolist() == [0, 1, 2, 3]


def test_temperature_and_its_rate_are_of_a_parabola() -> None:
    t = series(400).t
    T = 20.0 + 0.03 * (t - 100) - 1e-4 * (t - 100) ** 2
    T[7::9] = np.nan
    bins = equal_bins(series(400, temperature=T), 12)
    found, rate = bins.temperature
    since = bins.middle - 100.0
    np.testing.assert_allclose(found, 20.0 + 0.03 * since - 1e-4 * since**2, rtol=1e-9)
    np.testing.assert_allclose(rate, 60 * (0.03 - 2e-4 * since), rtol=1e-7)


@pytest.mark.filterwarnings("error")
def test_auxiliary_channels_are_averaged_over_what_is_known_of_them() -> None:
    volts = np.array([1.0, 2.0, np.nan, 4.0, np.nan, np.nan, 7.0, 9.0])
    recorded = replace(series(8), extra={"aux_volts": volts, "utc_s": np.arange(8.0)})
    found = Bins(recorded, np.array([0, 3, 4, 6, 8])).auxiliary
    assert found.keys() == {"volts"}
    np.testing.assert_array_equal(found["volts"], [1.5, 4.0, np.nan, 8.0])


@pytest.fixture(scope="module")
def fits() -> CampaignFits:
    campaign = planted(1, dwell_s=10.0, turns=True)
    return fit([replace(campaign, site=replace(campaign.site, magnetic=FIELD))])


def at_rest(fits: CampaignFits, position: int = 5, begin: float = 100.0, number: int = 0) -> StepNodes:
    recorded = replace(series(30, begin=begin), extra={} if begin > 100 else {"aux_volts": np.arange(30.0)})
    step = replace(STEP, position=position, campaign=number)
    return NodeBuilder(fits).rest(0, step, recorded, attitude(fits.campaigns[0], position), nodes=6)


def test_at_rest_gravity_earth_rate_and_field_are_seen_in_the_sensors_axes(fits: CampaignFits) -> None:
    campaign, part = fits.campaigns[0], at_rest(fits)
    C_sb = campaign.fixture.C_sb
    C_bl = np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0.0]])  # 5 SUW: where x, y, z point, East-North-Up
    g = campaign.site.gravity / 9.80665
    earth = (
        7.292115e-5 * 180 / np.pi * np.array([0, np.cos(campaign.site.latitude), np.sin(campaign.site.latitude)])
    )
    for found, expected in (
        (part.f, C_sb @ C_bl @ [0, 0, g]), (part.omega, C_sb @ C_bl @ earth), (part.magnetic, C_sb @ C_bl @ FIELD),
    ):  # fmt: skip
        np.testing.assert_allclose(found, np.tile(expected, (6, 1)), rtol=1e-6, atol=1e-12)
    accel = fits.accelerometer
    assert accel is not None
    np.testing.assert_allclose(part.accel_output * accel.k, part.f @ accel.K.T + accel.b, rtol=1e-12)
    np.testing.assert_allclose(np.diag(accel.k) @ part.E_accel, accel.K, rtol=1e-12)
    np.testing.assert_allclose(part.rest_s, 2.5 * np.arange(6) + 1.25)
    assert part.seconds.tolist() == [2.5] * 6
    np.testing.assert_array_equal(part.C_sb, C_sb)
    np.testing.assert_allclose(on_face(campaign, "y_up"), C_sb @ [0, g, 0], atol=1e-12)


def test_in_a_turn_what_is_fixed_to_the_earth_turns_back_as_the_gyros_say(fits: CampaignFits) -> None:
    gyroscope = fits.gyroscope
    assert gyroscope is not None
    campaign = fits.campaigns[0]
    earth = np.linalg.norm(np.degrees([0, 7.292115e-5]))
    for turn in gyroscope.turns:
        part = NodeBuilder(fits).turn(turn, STEP)
        assert part.seconds == pytest.approx(np.full(len(part.t), 0.1), abs=0.021)
        np.testing.assert_allclose(np.linalg.norm(part.magnetic, axis=1), np.linalg.norm(FIELD), rtol=1e-9)
        np.testing.assert_allclose(part.f, np.tile(part.f[0], (len(part.t), 1)), atol=1e-9)  # about the vertical
        C_sn = attitude(campaign, turn.record.start_position)
        np.testing.assert_allclose(part.f[0], C_sn[:, 2] * campaign.site.gravity / 9.80665, atol=1e-9)
        np.testing.assert_allclose(part.magnetic[[0, -1]], np.tile(C_sn @ FIELD, (2, 1)), atol=0.2)
        assert np.abs(part.omega).max() > 20.0
        for k, (now, then) in enumerate(pairwise(part.magnetic)):
            half = [part.omega[i] * part.seconds[i] / 2 for i in (k, k + 1)]
            back = Rotation.from_rotvec(np.radians(sum(half))).inv()
            slack = np.radians(0.5 + earth) * np.linalg.norm(
                FIELD
            )  # the mean rate of a bin is not that of its end
            assert np.linalg.norm(back.apply(now) - then) < slack
