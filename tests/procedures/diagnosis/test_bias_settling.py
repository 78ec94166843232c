"""A bias that settles since power-on is told from a drift, a jump and a coefficient of temperature."""

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, Finding
from tests.benchmarks.diagnosing.designs import plain, unit

TAU_S = 400.0
SIZES = {"accelerometer": {"x": 1e-5, "z": -6e-6}, "gyroscope": {"x": 1.0, "y": -0.7}}
SETTLING = ("accelerometer.bias_settling", "gyroscope.bias_settling")


def of_instrument(found: Diagnosis) -> list[Finding]:
    return [each for each in found.findings if each.kind == "instrument"]


def test_what_settles_is_named_with_its_size_and_time_constant() -> None:
    triad = "gyroscope"
    effects = {f"{triad}.bias_settling": {**SIZES[triad], "tau_s": TAU_S}}
    campaign = plain(unit(3, effects=effects), 3)
    (finding,) = of_instrument(diagnose(campaign))
    assert finding.effect == f"{triad}.bias_settling"
    begun = min(float(each.series.t[0]) for one in campaign for each in one.dwells)
    for name, value, std in zip(finding.coefficients, finding.value, finding.std, strict=True):
        left = TAU_S if name == "tau_s" else SIZES[triad].get(name, 0.0) * np.exp(-begun / TAU_S)
        assert abs(value - left) < 4 * std, name


def test_a_drift_stays_one() -> None:
    found = diagnose(plain(unit(4, effects={"gyroscope.bias_drift": {"x": 1.0, "y": -0.7}}), 4))
    (finding,) = of_instrument(found)
    assert (finding.effect, finding.confidence) == ("gyroscope.bias_drift", "established")


def test_what_a_settling_temperature_does_stays_a_coefficient_of_it() -> None:
    """The temperature recorded settles, too: a time constant of the bias's own would be one number more."""
    effects = {"gyroscope.bias_temperature": {"x": 0.3, "y": -0.2}}
    warm = unit(5, effects=effects, temperature_rise_k=6.0, temperature_tau_s=600.0)
    found = of_instrument(diagnose(plain(warm, 5)))
    assert [each.effect for each in found] == ["gyroscope.bias_temperature"]
    assert not {*SETTLING} & {*found[0].aliases}
