"""Steps by the words of people: in every text that is shown, and as they are typed."""

import re
from collections.abc import Callable

import pytest

from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Dwell, Turn, turn_steps
from station.guide.command import OperatorCommand
from station.guide.outcome import verdict_view
from station.guide.step_names import files_as_steps, for_people, gap_in_words, step_typed
from station.guide.text_lines import PlainScreen, command_of, listen, verdict_lines
from station.results.campaign_results import make_results
from station.stream.stream_events import Event
from tests.station.guide.rig import GuideRig, dwells
from tests.station.tui import views
from tests.station.tui.session import MemorySession

Make = Callable[..., GuideRig]
FILED = re.compile(r"\b(dwell|turn|free|soak)_\w|\.mcap|\.csv")


@pytest.mark.parametrize(
    ("filed", "said"),
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
def test_files_and_names_of_steps_become_words(filed: str, said: str) -> None:
    assert files_as_steps(filed) == said


@pytest.mark.parametrize(
    ("typed", "step"),
    [
        ("3", "dwell_03"), ("03", "dwell_03"), ("position 12", "dwell_12"), ("p4", "dwell_04"),
        ("dwell_03", "dwell_03"), ("x+", "turn_x_plus"), ("+x", "turn_x_plus"), ("X -", "turn_x_minus"),
        ("turn Y+", "turn_y_plus"), ("turn_y_minus", "turn_y_minus"), ("13", ""), ("w+", ""), ("x", ""),
    ],
)  # fmt: skip
def test_a_step_is_meant_by_what_people_type(typed: str, step: str) -> None:
    assert step_typed(files_as_steps(typed), views.steps(0)) == step


def test_free_positions_and_soaks_are_typed_by_their_number() -> None:
    for typed, step in (("free 2", "free_02"), ("f12", "free_12"), ("soak 1", "soak_01"), ("s2", "soak_02")):
        assert step_typed(typed, views.ONES) == step


def test_a_line_of_plain_mode_names_a_step_as_people_do() -> None:
    view = views.PLACING
    assert command_of("r 3", view) == OperatorCommand(verb="redo", step="dwell_03")
    assert command_of("n +x", view) == OperatorCommand(verb="choose", step="turn_x_plus")
    assert command_of("r dwell_03", view) == OperatorCommand(verb="redo", step="dwell_03")
    said = list[str]()
    listen(MemorySession(view), ["r 77"], said.append)
    assert said[0].startswith("there is no step '77'; keys, each followed by Enter")
    assert not FILED.search(said[0])


def test_a_gap_that_the_guide_made_is_called_what_it_is_and_lost_samples_are_not() -> None:
    left_out = {"dwell_02.mcap": [4.02]}
    knocked = gap_in_words("dwell_02.mcap:301: a gap of 4.02 s", left_out)
    assert files_as_steps(knocked) == "position 2: 4.0 s left out, the cube was disturbed; the rest was accepted"
    lost = gap_in_words("dwell_02.mcap:301: a gap of 0.06 s", left_out)
    assert files_as_steps(lost) == "position 2: a gap of 0.06 s: samples were lost"
    assert gap_in_words("anything else", left_out) == "anything else"


def test_views_for_people_name_no_file() -> None:
    event = Event(number=1, sound="", text="dwell_01 is done")
    view = views.PASSED.model_copy(
        update={
            "line": "dwell_02", "hint": "turn_x_plus.mcap", "error": "dwell_03.mcap:3: bad", "events": (event,),
            "verdict": views.PASSED.verdict.model_copy(update={"warnings": ("dwell_04.mcap: damaged",)}),
        }
    )  # fmt: skip
    shown = for_people(view)
    texts = [shown.line, shown.hint, shown.error, shown.events[0].text, *verdict_lines(shown.verdict)[:6]]
    assert not [text for text in texts if FILED.search(text)]
    assert shown.steps == view.steps


def test_a_whole_campaign_with_knocks_gaps_and_redone_steps_names_no_file_to_anybody(rig: Make) -> None:
    """Every view of a real campaign, its lines of text, and the verdict of its real solve."""
    steps = [*dwells(*range(1, 13), seconds=12.0), *turn_steps(1, 5.0)]
    guided = rig(steps, Truth.example(3), asks=False)
    lines = list[str]()
    screen = PlainScreen(lines.append, rings=False)
    guided.run(guided.done(1), screen.show)
    guided.hands("place 2 8")
    guided.run(lambda v: v.live == "dwell_02" and v.accepted_s > 7, screen.show)
    guided.hands("knock 1 0.5")
    guided.run(guided.done(2), screen.show)
    guided.obey("choose", step="dwell_01")
    for step in steps[2:]:
        start = step.position if isinstance(step, Dwell) else step.start_position
        guided.hands(f"place {start} 8")
        count = guided.view.done + 1
        if isinstance(step, Turn):
            guided.run(lambda v: v.turn is not None and v.turn.rest_s >= 5 and not v.turn.is_to_rest, screen.show)
            guided.hands(f"turn {step.axis} {step.direction} 1 2")
        if step == Dwell(5, 12.0):
            guided.run(lambda v: v.live == "dwell_05" and v.accepted_s > 5, screen.show)
            guided.source.device.plant("lost", 3)
        guided.run(guided.done(count), screen.show)
    texts = [text for view in guided.seen for text in (view.line, view.hint, *(e.text for e in view.events))]
    texts += [view.pose.text for view in guided.seen if view.pose]
    assert not {text for text in texts if FILED.search(text)}
    assert not [line for line in lines if FILED.search(line) and "recording into" not in line]
    with open_db(guided.folder.parent / "station.db") as database:
        verdict = verdict_view(make_results(guided.folder, database), database)
    said = [line for line in verdict_lines(verdict) if not line.endswith((".html", ".json"))]
    assert not [line for line in said if FILED.search(line)]
    assert "position" in verdict.worst_residual or "turn" in verdict.worst_residual
    assert any(w.startswith("position 5: a gap of ") and w.endswith("samples were lost") for w in verdict.warnings)
    assert any(w.startswith("position 2: ") and "left out, the cube was disturbed" in w for w in verdict.warnings)
