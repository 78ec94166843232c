"""A unit switched off and on within a campaign: an effect shows by what the steps of the biases leave of it."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.plan_steps import turn_steps
from procedures.diagnosis.diagnose import diagnose

pytestmark = pytest.mark.proof

STEP_G = np.array([4e-4, -2e-4, 3e-4])
FIRST = 3  # dwells before the unit is switched off


def switched(seed: int, tilt: FloatArray | None = None) -> Campaign:
    """Positions 1 to 3 at one turn-on, the others and the turns at the next; position 3 may lie askew."""
    effects = {} if tilt is None else {"placement.dwell": {"position": 3.0, "y": tilt[0], "z": tilt[1]}}
    truth = replace(Truth.example(seed), sample_period_s=0.02, effects=effects)
    before, after = (
        simulate_campaign(
            each,
            seed,
            dwell_s=20.0,
            turns=turn_steps(),
            move_s=25.0,
            moves=True,
            draw_stated=False,
            certificate_sigma=5e-6,
        )
        for each in (replace(truth, accel_d_g=truth.accel_d_g + STEP_G), truth)
    )
    later = [replace(each, turn_on=2) for each in after.dwells[FIRST:]]
    turns = tuple(replace(each, turn_on=2) for each in after.turns)
    return replace(after, dwells=(*before.dwells[:FIRST], *later), turns=turns)


def test_a_cube_that_is_tilted_before_the_unit_is_switched_off_is_named_and_the_instrument_is_not() -> None:
    found = diagnose([switched(1, np.array([-4e-4, 1e-3]))])
    seats = [each for each in found.findings if each.effect == "placement.dwell"]
    assert [(each.where["position"], each.confidence) for each in seats] == [(3, "established")]
    assert {each.kind for each in found.findings} <= {"bench", "procedure"}
    assert found.verdict == "established"


def test_steps_alone_are_no_effect() -> None:
    assert {each.kind for each in diagnose([switched(3)]).findings} <= {"bench"}  # its slab has a tilt
