"""Steps by the words of people: in every text that is shown, and as they are typed."""

import re
from collections.abc import Callable

import pytest

from station.guide.plain_screen import verdict_lines
from station.guide.step_names import files_as_steps, gap_in_words, step_named, without_file_names
from station.stream.stream_events import Event
from tests.station.guide.rig import GuideRig
from tests.station.tui import views

Make = Callable[..., GuideRig]
FILED = re.compile(r"\b(dwell|turn|free|soak)_\w|\.mcap|\.csv")


@pytest.mark.parametrize(
    ("filed", "reported"),
    [
        ("dwell_03", "position 3"),
        ("dwell_12.mcap:301: a gap of 2 s", "position 12: a gap of 2 s"),
        ("dwell_03_2.mcap, gyroscope z", "position 3, gyroscope z"),
        ("turn_x_plus.mcap", "turn X+"),
        ("both turn_z_minus and free_02", "both turn Z- and free position 2"),
        ("soak_01: warm", "soak 1: warm"),
        ("in /srv/c1/dwell_04.mcap", "in position 4"),
        ("a dwell, a turn and free positions", "a dwell, a turn and free positions"),
    ],
)
def test_files_and_names_of_steps_become_words(filed: str, reported: str) -> None:
    assert files_as_steps(filed) == reported


@pytest.mark.parametrize(
    ("typed", "step"),
    [
        ("3", "dwell_03"), ("03", "dwell_03"), ("position 12", "dwell_12"), ("p4", "dwell_04"),
        ("dwell_03", "dwell_03"), ("x+", "turn_x_plus"), ("+x", "turn_x_plus"), ("X -", "turn_x_minus"),
        ("turn Y+", "turn_y_plus"), ("turn_y_minus", "turn_y_minus"), ("13", ""), ("w+", ""), ("x", ""),
    ],
)  # fmt: skip
def test_a_step_is_meant_by_what_people_type(typed: str, step: str) -> None:
    assert step_named(files_as_steps(typed), views.steps(0)) == step


def test_a_gap_that_the_guide_made_is_called_what_it_is_and_lost_samples_are_not() -> None:
    left_out = {"dwell_02.mcap": [4.02]}
    disturbed = gap_in_words("dwell_02.mcap:301: a gap of 4.02 s at 30.5 s", left_out)
    assert (
        files_as_steps(disturbed)
        == "position 2: 4.0 s discarded, because the cube was disturbed; the rest was accepted"
    )
    lost = gap_in_words("dwell_02.mcap:301: a gap of 0.06 s at 1.25 s", left_out)
    assert files_as_steps(lost) == "position 2: a gap of 0.06 s at 1.25 s: samples were lost"
    assert gap_in_words("anything else", left_out) == "anything else"


def test_views_for_people_name_no_file() -> None:
    event = Event(number=1, sound="", text="dwell_01 is done")
    view = views.PASSED.model_copy(
        update={
            "line": "dwell_02", "hint": "turn_x_plus.mcap", "error": "dwell_03.mcap:3: bad", "events": (event,),
            "verdict": views.PASSED.verdict.model_copy(update={"warnings": ("dwell_04.mcap: damaged",)}),
        }
    )  # fmt: skip
    shown = without_file_names(view)
    texts = [shown.line, shown.hint, shown.error, shown.events[0].text, *verdict_lines(shown.verdict)[:6]]
    assert not [text for text in texts if FILED.search(text)]
    assert shown.steps == view.steps
