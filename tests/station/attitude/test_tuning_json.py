"""A tuning made by hand, as the document and the lines that are shown of it."""

import numpy as np
import pytest

from procedures.attitude.complementary_gains import Gains
from procedures.attitude.gain_tuning import GainTuning
from station.attitude.tuning_json import tuning_document

DEG = np.pi / 180
TUNING = GainTuning(
    candidates=(Gains(2.0, 1.0), Gains(0.5, 0.25), Gains(0.2, 0.04)),
    rms=np.array([4.0, 1.0, 2.0]) * DEG, by_fold=np.array([[4.0, 4.0], [1.0, 1.0], [2.0, 2.0]]) * DEG,
    best=1, picked=(1, 2), held_out=1.5 * DEG, rows=600,
)  # fmt: skip


def test_a_tuning_over_time_constants_gives_the_chosen_one_and_the_curve_in_degrees() -> None:
    document = tuning_document(TUNING, "gnss", by_tau=True)
    assert (document["format"], document["aid"], document["rows"], document["warnings"]) == (
        "tuning/1",
        "gnss",
        600,
        [],
    )
    assert document["chosen"] == {"tau_s": 4.0, "k1": 0.5, "k2": 0.25}  # tau = 2 / K1
    assert (document["rms_deg"], document["held_out_rms_deg"]) == pytest.approx((1.0, 1.5))
    assert document["chosen_without_stretch"] == [4.0, 10.0]
    assert [point["tau_s"] for point in document["curve"]] == [1.0, 4.0, 10.0]
    assert [point["rms_deg"] for point in document["curve"]] == pytest.approx([4.0, 1.0, 2.0])
    assert document["curve"][2]["by_stretch_deg"] == pytest.approx([2.0, 2.0])
