"""Noise that changes for good is told with its moment and size; too little, too short or too coarse is none."""

import numpy as np
import pytest
from scipy.stats import t as student_t

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RestRecord, Site
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.changed_noise import changed_noise
from procedures.diagnosis.disturbed_blocks import middle_half
from procedures.diagnosis.result import Finding

PERIOD = 0.1  # s: a block is 100 samples
BLOCK = 100
RAMP = np.linspace(-1.0, 1.0, BLOCK)


def blocks(sizes: FloatArray, length: int = BLOCK) -> FloatArray:
    """Return one sample after the other of blocks of such sizes, each a ramp."""
    return np.outer(sizes, np.linspace(-1.0, 1.0, length)).ravel()


def sizes(before: int, after: int, times: float, scatter: float = 0.1) -> FloatArray:
    """Return the sizes of blocks, by turns larger and smaller by ``scatter`` in the logarithm of the variance."""
    v = scatter / 2 * (-1.0) ** np.arange(before + after)
    return np.asarray(np.exp(v / 2) * np.where(np.arange(before + after) < before, 1.0, times))


def rest(
    gyro: FloatArray, accel: FloatArray | None = None, period: float = PERIOD, name: str = "log"
) -> RestRecord:
    n = len(gyro)
    t = period * (np.arange(n) + 1)
    return RestRecord(name, "z_up", RateSeries(t, gyro, accel, np.full(n, np.nan), period, np.array([0]), {}))


def found(*rests: RestRecord, scale: float = 1.0) -> list[Finding]:
    units = {"accelerometer": scale, "gyroscope": scale}
    site = Site(0.8, 9.8, 0.01)
    return list(changed_noise([Campaign("m", "s", False, site, (), (), rests=rests, nominal_scale=units)]))


def on(axis: int, x: FloatArray) -> FloatArray:
    """Return three channels, of which one is ``x`` and the others never change."""
    return np.outer(x, np.eye(3)[axis])


@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("times", [3.0, 1 / 3])
def test_a_finding_says_where_by_how_much_and_how_sure(axis: int, times: float) -> None:
    (finding,) = found(rest(on(axis, blocks(sizes(12, 8, times)))))
    sample = np.sqrt(middle_half(RAMP[None])[0])
    change = 3600 * sample * (times - 1)
    within = 20 * 0.05**2 / 18  # of ln variances: of twenty, two means taken off
    sigmas = 2 * np.log(3.0) / np.sqrt(within * (1 / 12 + 1 / 8))
    assert finding.where == {"file": "log", "channel": ("gx", "gy", "gz")[axis], "from_s": pytest.approx(120.1)}
    assert finding.value == pytest.approx([change])
    assert finding.std == pytest.approx([abs(change) / sigmas])
    assert finding.gain == 0.0
    places = 20 - 2 * 5 + 1  # of a change, five blocks on either side
    assert finding.log_p == pytest.approx(np.log(2 * student_t.sf(sigmas, 18) * places))
    assert (finding.effect, finding.kind, finding.coefficients) == ("disturbance.dwell", "procedure", ("value",))
    assert (finding.confidence, finding.aliases, finding.unit) == ("ambiguous", ("gyroscope.noise",), "deg/h")
    assert f"{times:.2g} times" in finding.shape


def test_an_accelerometer_is_told_in_g_by_its_scale_factor() -> None:
    x = blocks(sizes(10, 10, 2.0))
    (finding,) = found(rest(np.zeros((len(x), 3)), on(1, x)), scale=4.0)
    assert (finding.unit, finding.where["channel"], finding.aliases) == ("g", "ay", ("accelerometer.noise",))
    assert finding.value == pytest.approx([np.sqrt(middle_half(RAMP[None])[0]) / 4.0])


@pytest.mark.parametrize(("times", "is_told"), [(1.48, False), (1.52, True), (1 / 1.48, False), (1 / 1.52, True)])
def test_noise_must_change_by_half_of_itself(times: float, is_told: bool) -> None:
    assert bool(found(rest(on(0, blocks(sizes(10, 10, times)))))) == is_told
