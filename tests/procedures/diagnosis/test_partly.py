"""A cause of the catalogue beside one of none: the first is named with its share, the rest is said to be left."""

from procedures.diagnosis.diagnose import diagnose
from tests.benchmarks.diagnosing.designs import WARM, plain, unit
from tests.benchmarks.diagnosing.outside import outside

HEATED = {"accelerometer.bias_temperature": {"x": 15e-6, "y": -10e-6, "z": 20e-6}}


def test_what_is_known_is_named_and_what_is_left_is_shown() -> None:
    truth = unit(7, **WARM, effects=HEATED)
    found = diagnose(plain(truth, 7, outside("heading, accelerometers", 4e-6)))
    assert found.verdict == "partly"
    (known,) = (each for each in found.findings if each.effect == "accelerometer.bias_temperature")
    assert known.share > 0.9
    assert abs(known.value[0] - 15e-6) < 5 * known.std[0] + 2e-6  # what is left is in no sigma of a coefficient
    assert found.left[0].what == "accelerometer mean"
    assert all(each.share == 0.0 for each in found.findings if each.effect.startswith(("slab", "fixture")))
    assert found.unexplained_before is not None
