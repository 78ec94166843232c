"""What the bench did widens a calibration's uncertainty, whatever else is in doubt."""

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.uncertainty.budget import budget
from procedures.uncertainty.given_values import GivenValues
from tests.benchmarks.diagnosing.designs import certified, unit

SEED, CLOSURE_DEG = 3, 0.08


def expanded(fits, unexplained) -> np.ndarray:  # type: ignore[no-untyped-def]
    found = {each.name: each.expanded for each in budget(fits, GivenValues(unexplained=unexplained))}
    return np.array([found[f"gyroscope.scale_factor.{axis}"] for axis in "xyz"])


def test_it_does_so_too_where_an_effect_of_the_instrument_is_in_doubt_beside_it() -> None:
    """On faces K2 is one with an asymmetry: the calibration carries neither, but its turns stay as loose."""
    planted = {"procedure.closure": {"value": CLOSURE_DEG}, "accelerometer.quadratic": {"x": 5e-5}}
    truth = unit(SEED, effects=planted)
    found = diagnose(certified(truth, SEED))
    in_doubt = [each.effect for each in found.findings if each.kind == "instrument"]
    assert in_doubt == ["accelerometer.quadratic"]
    assert "procedure.closure" in {each.effect for each in found.findings}
    alone = found.bench_alone
    assert alone is not None
    wide, narrow = expanded(alone.fits, alone.unexplained), expanded(found.before, found.unexplained_before)
    off = np.abs(alone.solution.gyroscope.scale_factor.value - truth.gyro_k)
    assert np.all(wide > 3 * narrow)
    assert np.all(off < wide)
    assert np.any(off > narrow)
