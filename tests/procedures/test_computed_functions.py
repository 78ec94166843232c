"""What is computed once for many tests, functions and methods alike, is so where it is called."""

import sys
from importlib import import_module
from operator import attrgetter

import pytest

from tests.computed_once import COMPUTED


@pytest.mark.parametrize(("module", "name"), COMPUTED)
def test_each_function_named_knows_what_it_returned_wherever_it_is_called(module: str, name: str) -> None:
    plain = attrgetter(name)(import_module(module)).__wrapped__
    ours = [each for each in [*sys.modules] if each.startswith(("procedures.", "station."))]
    assert [each for each in ours if any(held is plain for held in vars(sys.modules[each]).values())] == []
