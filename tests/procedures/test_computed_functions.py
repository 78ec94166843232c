"""What is computed once for many tests, functions and methods alike, is so where it is called."""

from importlib import import_module
from operator import attrgetter

import pytest

from tests.computed_once import COMPUTED


@pytest.mark.parametrize(("module", "name"), COMPUTED)
def test_each_function_named_knows_what_it_returned(module: str, name: str) -> None:
    assert hasattr(attrgetter(name)(import_module(module)), "__wrapped__")
