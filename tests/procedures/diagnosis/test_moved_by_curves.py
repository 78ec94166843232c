"""What effects took of a cause in no catalogue is in the uncertainty, though the residual no longer has it."""

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from tests.procedures.diagnosis.half_explained import by_residual, expanded_bias, half_explained


def test_a_pressure_that_a_temperature_coefficient_took_a_part_of_is_in_the_uncertainty_of_the_bias() -> None:
    made = half_explained(16)
    found = diagnose(made.campaigns)
    assert found.verdict == "partly"
    assert found.solution.accelerometer is not None
    off = np.abs(found.solution.accelerometer.bias.value - made.bias_g)
    assert np.any(off > 2 * expanded_bias(found, by_residual(found)))  # the residual alone does not tell
    assert np.all(off < expanded_bias(found, found.unexplained))
    assert np.all(expanded_bias(found, found.unexplained) < 2 * made.size_g)


def test_where_nothing_but_temperature_acts_nothing_moves_and_nothing_is_added() -> None:
    made = half_explained(16, size_g=0.0)
    found = diagnose(made.campaigns)
    assert found.verdict != "partly"
    assert found.unexplained is None
    assert found.solution.accelerometer is not None
    off = np.abs(found.solution.accelerometer.bias.value - made.bias_g)
    assert np.all(off < expanded_bias(found, None))
