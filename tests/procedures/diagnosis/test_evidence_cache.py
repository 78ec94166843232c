"""A process that goes on holds no diagnosis but those that it holds itself."""

import gc
import weakref
from dataclasses import replace

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.validation_campaigns import validate
from station.results.diagnosis.finding_residuals import residual_panels
from tests.procedures.diagnosis.test_polynomial_orders import campaign, following


def test_a_diagnosis_goes_when_nobody_holds_it_any_more() -> None:
    soak = campaign(3, 2e-5 * (following(900.0) - 25))
    found = diagnose([soak])
    assert residual_panels(found)
    again = replace(soak, serial="b")
    assert validate(found, [again])
    held = [weakref.ref(found.evidence), *(weakref.ref(each.series.accel) for each in soak.soaks)]
    assert all(each() is not None for each in held)
    del found, soak, again
    gc.unfreeze()  # a look in between may have frozen it
    gc.collect()
    assert [each() for each in held] == [None] * len(held)
