"""The first position again at the end: a step of its own, which a redo of the first does not touch."""

from collections.abc import Callable

from procedures.campaign.plan_steps import Dwell, as_repeats
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.setup import Setup
from station.guide.live_campaign import usual_steps
from station.guide.step_names import files_as_steps, step_typed
from station.tui.widgets.step_grid import GridCursor
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def files(guided: GuideRig) -> list[str]:
    return [dwell.name for dwell in read_campaign(guided.folder).campaign.dwells]


def test_the_usual_plan_ends_as_it_began_unless_it_is_told_not_to() -> None:
    steps = usual_steps(Setup(dwell_s=60.0))
    assert (len(steps), steps[0], steps[-1]) == (19, Dwell(1, 60.0), Dwell(1, 60.0, 1))
    assert usual_steps(Setup(dwell_s=60.0, repeats=0)) == steps[:-1]
    assert [step.name for step in usual_steps(Setup(repeats=2))[-2:]] == ["dwell_01_repeat", "dwell_01_repeat2"]


def test_a_repeat_waits_for_its_turn_and_wants_a_seating_of_its_own(rig: Make) -> None:
    guided = rig(as_repeats(dwells(1, 2, 1)))
    guided.run(guided.done(1))
    guided.hands("place 1 8")
    view = guided.run(lambda v: any(e.sound == "rejected" for e in v.events))
    assert view.events[-1].text == "position 1 is done already; position 2 is the same face turned by 180 deg"
    guided.hands("place 2 8")
    view = guided.run(guided.done(2))
    assert view.wanted == "dwell_01_repeat"
    assert view.line == "put the cube in position 1 once more: X up, Y east, Z north"
    guided.hands("place 1 8")
    guided.run(guided.done(3))
    assert guided.texts[-1] == "accepted: accepted: position 1 repeated, 3 of 3 done"
    assert files(guided) == ["dwell_01.mcap", "dwell_02.mcap", "dwell_01_repeat.mcap"]
    assert [d.position for d in read_campaign(guided.folder).campaign.dwells] == [1, 2, 1]


def test_a_redone_repeat_replaces_itself_alone_also_after_a_kill(rig: Make) -> None:
    guided = rig(as_repeats(dwells(1, 2, 1)))
    for count, position in enumerate((1, 2, 1), start=1):
        guided.hands(f"place {position} 8")
        guided.run(guided.done(count))
    guided.resume()
    assert guided.guide.is_complete
    assert set(guided.context.accepted_dwells) == {"dwell_01", "dwell_02", "dwell_01_repeat"}
    for redone, left in (
        ("dwell_01_repeat", ["dwell_01.mcap", "dwell_02.mcap", "dwell_01_repeat_2.mcap"]),
        ("dwell_01", ["dwell_02.mcap", "dwell_01_repeat_2.mcap", "dwell_01_2.mcap"]),
    ):
        guided.obey("redo", step=redone)
        guided.hands("place 1 8")
        guided.run(lambda v, name=redone: v.step(name).attempts == 2)
        assert files(guided) == left
    guided.resume()
    assert {step.name: step.attempts for step in guided.view.steps} == {
        "dwell_01": 2, "dwell_02": 1, "dwell_01_repeat": 2,
    }  # fmt: skip


def test_people_read_and_type_repeats_by_their_position(rig: Make) -> None:
    guided = rig(as_repeats(dwells(1, 2, 1, 1)))
    steps = guided.view.steps
    assert (
        files_as_steps("dwell_01_repeat_2.mcap:7 and dwell_01_repeat2")
        == "position 1 repeated and position 1 repeated (2)"
    )
    for typed, name in (("1", "dwell_01"), ("1r", "dwell_01_repeat"), ("position 1 repeated", "dwell_01_repeat"),
                        ("dwell_01_repeat2", "dwell_01_repeat2"), ("2r", "")):  # fmt: skip
        assert step_typed(typed, steps) == name
    places = GridCursor(steps).places
    assert (places["dwell_01"], places["dwell_01_repeat"], places["dwell_01_repeat2"]) == ((0, 0), (2, 0), (2, 1))
