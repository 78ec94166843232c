"""A name that is outdone by a plain curve of what the cause goes with is in doubt."""

from functools import cache

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.catalogue import KINDS
from tests.benchmarks.undeclared_kinds.judged import Outcome, told
from tests.benchmarks.undeclared_kinds.sized import sized

SEED = 370_000


@cache
def outcome(kind: str, seed: int) -> Outcome:
    return told(KINDS[kind], seed)


def test_a_scale_factor_that_ages_is_no_sure_jump() -> None:
    kind = KINDS["scale factor ages"]
    truth = truth_of(kind.design, SEED)
    found = diagnose(campaigns_of(truth, kind.design, SEED, kind.planted(SEED, truth, 1e-4)).campaigns)
    assert all(each.confidence == "ambiguous" for each in found.findings if each.kind == "instrument")
    assert found.verdict in {"partly", "unexplained"}


def test_undeclared_kinds_get_no_wrong_name() -> None:
    """The benchmark's short version: two that are in no catalogue, and one that is."""
    assert outcome("g squared", 1).word in {"unexplained", "partly", "group without it"}
    assert outcome("Shupe effect", 3).word in {"named", "group led by it"}


def test_half_of_a_hysteresis_is_not_sure() -> None:
    """A play was an established coefficient beside a rate in doubt."""
    word = outcome("hysteresis of a MEMS package", 75_002).word
    assert word in {"group with it", "group without it", "group led by it"}


def test_a_bias_that_walks_is_no_scatter_of_seats() -> None:
    """A jump took the walk's largest step, and seats were likely for the others."""
    assert outcome("rate random walk", 405_000).word == "partly"


@pytest.mark.parametrize(
    ("kind", "seed"), [("dead zone", 230_900), ("rectified rate", 300_900), ("range ends", 310_900)]
)
def test_a_function_of_the_input_is_no_scatter(kind: str, seed: int) -> None:
    """Draws of every heading, seat or closure fit it as well, but a few coefficients of the input are likelier."""
    assert outcome(kind, seed).word in {"partly", "unexplained"}


def test_a_bend_that_shows_in_the_closures_alone_is_kept_and_explains_what_it_does() -> None:
    """A turn that is left out brings its own closure: the turns by themselves are foretold without the bend."""
    kind, seed = KINDS["open loop at three speeds"], 159_000
    truth = truth_of(kind.design, seed)
    size, _, _ = sized(kind, seed)
    found = diagnose(campaigns_of(truth, kind.design, seed, kind.planted(seed, truth, size)).campaigns)
    (bend,) = (each for each in found.findings if each.kind == "instrument")
    assert bend.effect == "gyroscope.scale_nonlinearity"
    assert bend.share > 0.9
    assert found.log_p > np.log(0.01)
