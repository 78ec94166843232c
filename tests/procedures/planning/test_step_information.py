"""What a step adds to what is known: it hangs on the unit's noise, its rows do not."""

import numpy as np

from procedures.planning.campaign_design import Placing
from tests.procedures.planning.bench_of_moves import bench, unit


def test_a_unit_of_other_noise_has_the_same_rows_and_is_weighed_anew() -> None:
    steps = bench(unit()).steps
    at = Placing(1, 60.0)
    quiet = steps.placed(at, True)
    noisy = steps.with_noise(steps.noise.times(10.0, 10.0))
    assert noisy.rows is steps.rows
    told = noisy.placed(at, True)
    assert np.trace(told) < np.trace(quiet)
    assert not np.allclose(told, quiet)
    assert np.array_equal(steps.placed(at, True), quiet)
