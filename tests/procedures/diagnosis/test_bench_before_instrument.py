"""What is likelier at a bench than an effect of the instrument is named in its place."""

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from tests.benchmarks.diagnosing.designs import plain, repeated, unit


@pytest.mark.parametrize(("seed", "off_deg"), [(5, -0.35)])
def test_a_latitude_that_is_wrong_is_no_magnetic_sensitivity(seed: int, off_deg: float) -> None:
    off = float(np.radians(off_deg))
    found = diagnose(plain(unit(seed, effects={"site.latitude": {"value": off}}), seed))
    (site,) = (each for each in found.findings if each.effect == "site.latitude")
    assert abs(site.value[0] - off) < 4 * site.std[0]
    assert not [each.effect for each in found.findings if each.effect.startswith("gyroscope")]


def test_a_jump_while_the_cube_rests_is_found_within_its_dwell() -> None:
    """Taken for one between two dwells it left half of itself in that dwell, and the name with it."""
    jumped = {"accelerometer.jump": {"y": 8.08e-6, "after_s": 681.0}}  # dwell_05 is from 625.1 to 725.1 s
    found = diagnose(repeated(unit(570_002, effects=jumped), 570_002))
    (jump,) = (each for each in found.findings if each.kind == "instrument")
    assert (jump.effect, jump.confidence, jump.where["in"]) == ("accelerometer.jump", "established", "dwell_05")
    assert abs(float(str(jump.where["after_s"])) - 55.9) < 100 / 16
    assert abs(jump.value[1] - 8.08e-6) < 4 * jump.std[1]
    assert found.log_p > np.log(0.01)
