"""A solution that hangs on which of two seatings it was says so in its sigmas."""

import numpy as np

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
