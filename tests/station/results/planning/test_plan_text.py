"""What a plan says of an effect: that it is told, from what it is not told apart, or that it is not."""

import pytest

from station.results.planning import plan_text


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (None, "no"),
        ({"is_told": False, "not_apart": []}, "no"),
        ({"is_told": True, "not_apart": []}, "yes"),
        ({"is_told": True, "not_apart": ["a drift", "a jump"]}, "yes, or a drift, or a jump"),
    ],
)
def test_an_effect_is_told_or_not_or_taken_for_another(told: dict[str, object] | None, said: str) -> None:
    assert plan_text._told(told) == said  # noqa: SLF001
