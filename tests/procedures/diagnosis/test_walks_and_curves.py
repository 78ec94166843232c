"""What goes by time against walks and curves: a drift and a jump outdo them where they were planted, else not."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.other_memories import remembers_otherwise
from procedures.diagnosis.outdone import outdone_by, scatter_outdone_by, steps_beside_steps_in_doubt
from procedures.diagnosis.walk_rivals import lost_in_a_walk, steps_of_a_walk, walk_in_place_of, walk_outdoes
from tests.procedures.diagnosis.found_already import finding, stands, ways_of
from tests.procedures.diagnosis.redrawn import seen_by

TRIADS = ("accelerometer", "gyroscope")


def does(way: Candidate, sigmas: float = 40.0) -> FloatArray:
    """Return what an effect does to all rows, so many sigmas together, the same in each sensor."""
    _, evidence, _ = seen_by("plain")
    fit = way.without(evidence)
    done = way.term.H.sum(axis=1) / evidence.sigma
    left = done - fit.Q[: len(done)] @ (fit.Q[: len(done)].T @ done)
    return np.asarray(sigmas * done / np.linalg.norm(left) * evidence.sigma)


def walked(triad: str, seed: int, sigmas: float = 400.0) -> FloatArray:
    _, evidence, _ = seen_by("plain")
    H = steps_of_a_walk(evidence, triad)
    return np.asarray(H @ np.random.default_rng(seed).standard_normal(H.shape[1]) * sigmas)


@pytest.mark.parametrize("triad", TRIADS)
def test_a_drift_outdoes_a_walk_and_a_walk_outdoes_a_drift_where_each_was(triad: str) -> None:
    (drift,) = ways_of(f"{triad}.bias_drift")
    state = stands(does(drift), drift)
    assert walk_outdoes(state, state.adopted[0]) < -1
    assert not lost_in_a_walk(state, state.adopted[0])
    state = stands(walked(triad, 2), drift)
    assert walk_outdoes(state, state.adopted[0]) > 3
    assert lost_in_a_walk(state, state.adopted[0])


def test_what_does_not_go_by_time_is_held_against_no_walk() -> None:
    (way,) = ways_of("accelerometer.quadratic")
    state = stands(walked("accelerometer", 2), way)
    assert walk_outdoes(state, state.adopted[0]) == -np.inf
    assert not lost_in_a_walk(state, state.adopted[0])


def test_a_jump_is_never_lost_in_a_walk_but_may_be_outdone() -> None:
    jump = ways_of("gyroscope.jump")[40]
    state = stands(walked("gyroscope", 2), jump)
    assert walk_outdoes(state, state.adopted[0]) > 3
    assert not lost_in_a_walk(state, state.adopted[0])


@pytest.mark.parametrize("triad", TRIADS)
def test_a_walk_is_likelier_than_seats_where_a_bias_walked(triad: str) -> None:
    (seats,) = ways_of("placement.scatter")
    state = stands(walked(triad, 3), seats)
    assert walk_in_place_of(state, state.adopted[0]) > 3
    size = np.random.default_rng(4).standard_normal(seats.term.H.shape[1]) * 5 * seats.term.plausible
    state = stands(
        seats.term.H @ size, replace(seats, term=replace(seats.term, plausible=5 * seats.term.plausible))
    )
    assert walk_in_place_of(state, state.adopted[0]) < -3
    assert scatter_outdone_by(state, state.adopted[0]).by < 0


def test_no_curve_does_better_than_a_drift_that_was_planted_but_than_another_name_of_it() -> None:
    (drift,), (other,) = ways_of("accelerometer.bias_drift"), ways_of("accelerometer.quadratic")
    state = stands(does(drift), drift)
    assert outdone_by(state, state.adopted).by < 3
    state = stands(does(drift), other)
    assert outdone_by(state, state.adopted).by > 3


@pytest.mark.parametrize("name", ["accelerometer.quadratic", "gyroscope.bias_drift", "placement.dwell"])
def test_what_has_no_memory_remembers_nothing_otherwise(name: str) -> None:
    way = ways_of(name)[0]
    assert not remembers_otherwise(stands(does(way), way), way)


@pytest.mark.parametrize(
    ("places", "apart", "doubtful"),
    [
        (("soak", "soak"), 0.0, (True, True)), (("soak", "other"), 0.0, (False, False)),
        (("soak", "soak"), 1.0, (False, False)), (("soak", ""), 0.0, (False, False)),
    ],
)  # fmt: skip
def test_two_steps_of_one_soak_within_three_blocks_are_in_doubt(
    places: tuple[str, str], apart: float, doubtful: tuple[bool, bool]
) -> None:
    """The first two dwells are taken for a soak's blocks."""
    jump = ways_of("gyroscope.jump")[0]
    state = stands(0.0)
    seen = state.now.evidence.excitation
    steps = tuple(replace(step, kind="soak") if i < 2 else step for i, step in enumerate(seen.steps))
    evidence = replace(state.now.evidence, excitation=replace(seen, steps=steps))
    longest = max(float(np.ptp(seen.t[seen.step == i])) for i in range(2))
    at = (500.0, 500.0 + 3 * longest * (0.99 if apart == 0 else 1.01))
    ways = [
        replace(jump, columns=replace(jump.columns, where={"in": place, "after_s": then} if place else {}))
        for place, then in zip(places, at, strict=True)
    ]
    state = stands(0.0, *ways)
    object.__setattr__(state.now, "evidence", evidence)
    found = steps_beside_steps_in_doubt(state, state.adopted, [finding(each) for each in state.adopted])
    assert tuple(each.confidence == "ambiguous" for each in found) == doubtful
