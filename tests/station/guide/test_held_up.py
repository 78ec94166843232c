"""While a round lasts, the screens hear that the disk is slow; what says so itself is left alone."""

import pytest

from station.guide import held_up
from station.guide.held_up import HeldUpWatch
from station.guide.view import CalibrationView
from tests.patience import until


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(held_up, "HELD_UP_S", 0.05)
    monkeypatch.setattr(held_up, "LOOK_S", 0.01)


def test_a_round_that_lasts_is_said_and_no_other() -> None:
    view, seen = CalibrationView(stage="dwell", line="position 3", hint="still"), list[CalibrationView]()
    with HeldUpWatch(lambda: view, seen.append) as watch:
        with watch.round():
            until(lambda: bool(seen))
        told = len(seen)
        with watch.round():
            pass
        assert len(seen) <= told + 1
    assert seen[0].line == "position 3"
    assert "writing to the disk for " in seen[0].hint
    assert "what was accepted is safe" in seen[0].hint


@pytest.mark.parametrize("stage", ["solving", "connecting", "verdict", "failed"])
def test_what_says_itself_what_it_does_is_left_alone(stage: str) -> None:
    view, seen, looks = CalibrationView(stage=stage), list[CalibrationView](), list[int]()  # type: ignore[arg-type]

    def shown() -> CalibrationView:
        looks.append(1)
        return view

    with HeldUpWatch(shown, seen.append) as watch, watch.round():
        until(lambda: len(looks) > 10)
    assert seen == []
