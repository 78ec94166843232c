"""The long proofs of `tests.benchmarks`, in short."""

import pytest

from tests.benchmarks import false_accept, kills


@pytest.mark.proof
def test_a_campaign_killed_again_and_again_is_the_same_campaign() -> None:
    reported = kills.run(kills=4, seed=2, steps=4)
    assert reported["kills"] >= 4
    assert (reported["faults"], reported["other_solutions"]) == (0, 0)


def test_what_is_off_is_never_accepted_and_what_is_right_is() -> None:
    outcomes = [false_accept.trial(seed) for seed in range(14)]
    assert not [kind for kind, outcome in outcomes if outcome in {"tilted", "mistaken"}]
    assert {outcome for kind, outcome in outcomes if kind in {"flat", "tapped"}} == {"accepted"}
    assert {outcome for kind, outcome in outcomes if kind == "tilted"} == {"refused"}
