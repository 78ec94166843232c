"""A mean that follows the variance of the vibration from dwell to dwell: seen, named, and not made up."""

from dataclasses import replace

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.diagnose import diagnose
from procedures.inference.result import Diagnosis, Finding

RMS_G = 0.03
ACCELEROMETER, GYROSCOPE = (f"{triad}.vibration_rectification" for triad in ("accelerometer", "gyroscope"))


def shaken(name: str, seed: int = 3, **sizes: float) -> Campaign:
    """Twelve positions, of which the odd ones shake along every axis."""
    truth = replace(Truth.example(seed), effects={name: {"rms_g": RMS_G, "hz": 2.37, **sizes}})
    return simulate_campaign(truth, seed, dwell_s=60.0, certificate_sigma=2e-6)


def named(found: Diagnosis, name: str) -> Finding:
    (one,) = (each for each in found.findings if each.effect == name)
    return one


def test_a_mean_that_follows_the_variance_is_named_with_its_size() -> None:
    name, size, rms = ACCELEROMETER, 2e-3, RMS_G
    one = named(diagnose([shaken(name, y=size, rms_g=rms)]), name)
    assert one.confidence in {"established", "likely"}
    at = one.coefficients.index("y")
    assert abs(one.value[at] - size) < 4 * one.std[at]
    assert one.std[at] < abs(size) / 5
