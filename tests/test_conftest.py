"""Little looking for garbage must not change what those see who look for themselves."""

import gc

import pytest

from tests.paths import ROOT


class Held:
    pass


def test_who_looks_for_garbage_is_told_who_holds_an_object() -> None:
    """Hypothesis asks so in a process's first test where CI is set, and warns where nobody is named."""
    held = [Held()]
    gc.collect()
    assert _is_told(held)


def test_what_a_look_left_is_frozen_once_the_test_is_over(request: pytest.FixtureRequest) -> None:
    plugins = request.config.pluginmanager.get_plugins()
    (conftest,) = (each for each in plugins if getattr(each, "__file__", "") == str(ROOT / "tests/conftest.py"))
    conftest.pytest_runtest_logfinish()  # a look before this test is none in it
    held = [Held()]
    gc.collect(0)
    assert _is_told(held)
    conftest.pytest_runtest_logfinish()
    assert not _is_told(held)


def _is_told(held: list[Held]) -> bool:
    return any(each is held for each in gc.get_referrers(held[0]))
