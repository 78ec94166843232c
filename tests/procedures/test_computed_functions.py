"""What is computed once for many tests, functions and methods alike, is so where it is called."""

import sys
from importlib import import_module
from operator import attrgetter

import pytest

from procedures.frames import POSITIONS
from tests.computed_once import COMPUTED, pickled
from tests.procedures.planning.bench_of_moves import bench, order, unit


@pytest.mark.parametrize(("module", "name"), COMPUTED)
def test_each_function_named_knows_what_it_returned_wherever_it_is_called(module: str, name: str) -> None:
    plain = attrgetter(name)(import_module(module)).__wrapped__
    ours = [each for each in [*sys.modules] if each.startswith(("procedures.", "station."))]
    assert [each for each in ours if any(held is plain for held in vars(sys.modules[each]).values())] == []


def test_what_a_plan_has_found_out_meanwhile_is_no_part_of_the_question() -> None:
    sigmas = bench(unit())
    before = pickled(sigmas)
    assert len(sigmas.of(order(list(POSITIONS)))) == 30  # and remembers what each placing adds
    assert pickled(sigmas) == before
    assert pickled(bench(unit(wander=1.0))) != before
