"""A tuning made by hand, as the document and the lines that are shown of it."""

import numpy as np
import pytest

from procedures.attitude.complementary_gains import Gains
from procedures.attitude.gain_tuning import GainTuning
from station.attitude.tuning_json import tuning_document, tuning_text

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


def test_a_tuning_over_both_gains_gives_both() -> None:
    document = tuning_document(TUNING, "none", by_tau=False)
    assert document["chosen"] == {"k1": 0.5, "k2": 0.25}
    assert document["chosen_without_stretch"] == [[0.5, 0.25], [0.2, 0.04]]
    text = tuning_text(document).splitlines()
    assert text[1].startswith("K1  2.0000 K2 1.00000")
    assert text[4] == "chosen: --k1 0.5 --k2 0.25; on stretches that had no say 1.5000 deg rms"


def test_the_bars_are_by_the_errors_logarithm_and_the_least_is_marked() -> None:
    text = tuning_text(tuning_document(TUNING, "gnss", by_tau=True) | {"warnings": ["at the end"]}).splitlines()
    assert text[0] == "error against truth, aid gnss, 600 rows"
    # the least has one mark, the most forty; twice the least, half way to four times, 1 + 39 / 2
    assert [line.count("#") for line in text[1:4]] in ([40, 1, 20], [40, 1, 21])
    assert [line.endswith(" <- least") for line in text[1:4]] == [False, True, False]
    assert text[2].startswith("tau       4 s    1.0000 deg #")
    assert text[4:] == ["chosen: --tau 4; on stretches that had no say 1.5000 deg rms", "warning: at the end"]


def test_equal_errors_have_equal_bars() -> None:
    even = GainTuning(TUNING.candidates, np.full(3, DEG), np.full((3, 2), DEG), 0, (0, 0), DEG, 600)
    document = tuning_document(even, "gnss", by_tau=True)
    assert [line.count("#") for line in tuning_text(document).splitlines()[1:4]] == [1, 1, 1]
    assert document["warnings"] == ["the best stands at the end of the grid"]
