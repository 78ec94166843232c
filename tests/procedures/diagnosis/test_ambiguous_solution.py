"""A solution that hangs on which of two seatings it was says so in its sigmas."""

from dataclasses import replace

import numpy as np

from procedures.diagnosis.ambiguous_solution import widened_by_alternative
from procedures.diagnosis.diagnose import diagnose
from tests.benchmarks.diagnosing.designs import plain, unit


def test_parallelism_holds_the_truth_whichever_seating_is_taken() -> None:
    truth = unit(11, effects={"placement.dwell": {"position": 7.0, "x": 3e-4, "z": -3e-4}})
    found = diagnose(plain(truth, 11))
    (seating,) = [each for each in found.findings if each.effect == "placement.dwell"]
    assert set(np.atleast_1d(seating.where["position"])) == {7, 8}
    faces = truth.faces_rad.reshape(3, 2, 2).sum(axis=1)
    off = (found.solution.parallelism.value - faces) / found.solution.parallelism.std
    assert np.all(np.abs(off) < 4)
    assert found.solution.parallelism.std[1].min() > 5e-5 > 5e-6 > found.solution.parallelism.std[[0, 2]].max()


def test_covariance_and_sigmas_agree() -> None:
    found = diagnose(plain(unit(12), 12)).solution
    moved = replace(found, parallelism=replace(found.parallelism, value=found.parallelism.value + 1e-4))
    moved = replace(
        moved, gyroscope=replace(found.gyroscope, bias=replace(found.gyroscope.bias, value=np.ones(3)))
    )
    wide = widened_by_alternative(found, moved)
    std = np.sqrt(np.diag(wide.covariance))
    of = {name: std[i] for i, name in enumerate(wide.names)}
    pairs = [name for name in wide.names if name.startswith("fixture.parallelism")]
    np.testing.assert_allclose([of[name] for name in pairs], wide.parallelism.std.ravel(), rtol=1e-6)
    biases = [of[f"gyroscope.bias.{axis}"] for axis in "xyz"]
    np.testing.assert_allclose(biases, wide.gyroscope.bias.std, rtol=1e-6)
    np.testing.assert_allclose(wide.accelerometer.bias.std, found.accelerometer.bias.std)
