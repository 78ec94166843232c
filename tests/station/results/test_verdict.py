"""A gyroscope of three biases, held against limits on either side, guarded and not."""

from typing import Any

import pytest

from fixtures_db.imu_models import Limit
from station.results.verdict import judge, judged_in_words, verdict_in_words

BIAS = {"value": [0.9, -0.2, 0.05], "std": [0.1, 0.01, 0.01], "unit": "deg/h"}
X, Y, Z = (f"gyroscope.bias.{axis}" for axis in "xyz")


def document(**bias: Any) -> dict[str, Any]:
    return {"model": "FOG3", "serial": "S1", "gyroscope": {"bias": BIAS | bias}}


def limit(name: str, low: float | None, high: float | None, guard: float = 0.0, unit: str = "deg/h") -> Limit:
    return Limit(name, low, high, unit, guard)


@pytest.mark.parametrize(
    ("low", "high", "word", "share"),
    [
        (-1.0, 1.0, "PASS", 0.9), (0.0, 0.9, "PASS", 1.0), (0.9, 2.9, "PASS", 1.0), (0.5, 1.5, "PASS", 0.2),
        (-0.5, 0.5, "FAIL", 1.8), (1.0, 2.0, "FAIL", 1.2), (None, 1.2, "PASS", 0.75), (None, 0.6, "FAIL", 1.5),
        (0.45, None, "PASS", 0.5), (1.8, None, "FAIL", 2.0), (None, -1.0, "FAIL", None),
        (-1.0, None, "PASS", None),
    ],
)  # fmt: skip
def test_a_value_is_judged_by_both_ends_and_how_near_it_stands(
    low: float | None, high: float | None, word: str, share: float | None
) -> None:
    (one,) = judge(document(), [limit(X, low, high)]).judged
    assert one.word == word
    assert one.share == (None if share is None else pytest.approx(share))


def test_a_guard_band_takes_its_sigmas_off_both_ends() -> None:
    assert judge(document(), [limit(X, -1.05, 1.05, guard=1.4)]).word == "PASS"
    assert judge(document(), [limit(X, -1.05, 1.05, guard=1.6)]).word == "FAIL"
    assert judge(document(), [limit(X, 0.75, None, guard=1.6)]).word == "FAIL"
    # a combined uncertainty stands for the document's sigma
    assert judge(document(), [limit(X, -1.05, 1.05, guard=1.4)], {X: 0.2}).word == "FAIL"
    (one,) = judge(document(), [limit(X, -0.1, 0.1, guard=2.0)]).judged
    assert (one.word, one.share) == ("FAIL", float("inf"))
    assert judged_in_words(one).endswith("minus 2 u (u is too large: no value is accepted)")


def test_the_tightest_is_named_where_all_pass() -> None:
    found = judge(document(), [limit(X, -1.0, 1.0), limit(Y, -0.21, 0.21), limit(Z, -1.0, 1.0)])
    assert (found.word, found.exit_code) == ("PASS", 0)
    assert found.sentence == (
        "PASS: FOG3 S1 is within all 3 limits of its model. Closest to its limit: gyroscope bias y, "
        "which uses 95 % of the allowed range"
    )


def test_the_worst_is_named_where_one_fails_though_another_was_not_measured() -> None:
    other = limit("accelerometer.bias.x", -1.0, 1.0, unit="g")
    found = judge(document(), [limit(X, -0.5, 0.5), limit(Y, -0.01, 0.01), limit(Z, -1.0, 1.0), other])
    assert (found.word, found.exit_code) == ("FAIL", 1)
    reported = "FOG3 S1 exceeds 2 of 4 limits of its model: gyroscope bias x, gyroscope bias y. Largest excess:"
    assert found.reason == f"{reported} gyroscope bias y, -0.200 deg/h; limit +-0.01 deg/h"


def test_what_has_no_value_or_no_limit_is_not_measured() -> None:
    others = [limit(f"accelerometer.bias.{axis}", -1.0, 1.0, unit="g") for axis in "xyz"]
    found = judge(document(), [limit(X, -1.0, 1.0), *others])
    assert (found.word, found.in_words, found.exit_code) == ("NOT_MEASURED", "NOT MEASURED", 0)
    assert "3 of 4 limited parameters of FOG3 S1 were not measured: accelerometer bias x" in found.reason
    assert judge(document(unit="deg/s"), [limit(X, -1.0, 1.0)]).word == "NOT_MEASURED"
    none = judge(document(), [])
    assert (none.word, none.in_words) == ("NOT_MEASURED", "NO LIMITS")
    assert verdict_in_words("NOT_MEASURED", has_limits=True) == "NOT MEASURED"
