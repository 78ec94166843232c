"""Positions beyond the twelve, named by where the cube's axes point, and repeated ones."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from procedures.campaign.plan_steps import Dwell, Soak, as_repeats
from procedures.earth.gyrocompass import quarters_to, turned_position
from procedures.frames import ATTITUDES, FACES, face_of, nominal_C_lb, vertical_rotation
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_toml import read_plan, write_plan
from station.files.setup import Setup
from station.guide.instruction_words import instruction, step_title
from station.guide.live_campaign import usual_steps
from station.guide.step_names import files_as_steps, step_typed
from station.tui.orientation import faces
from station.tui.widgets.step_grid import GridCursor
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]
SDE = ATTITUDES.index("SDE") + 1


@pytest.mark.parametrize("face", FACES)
def test_each_face_has_four_positions_a_quarter_turn_apart(face: str) -> None:
    found = [turned_position(face, quarter) for quarter in range(4)]
    assert sorted(found) == [p for p in range(1, 25) if face_of(p) == face]
    for before, after in zip(found, [*found[1:], found[0]], strict=True):
        turned = vertical_rotation(np.pi / 2) @ nominal_C_lb(before)
        assert turned == pytest.approx(nominal_C_lb(after))
    assert [quarters_to(found[2], quarter) for quarter in range(4)] == [2, 1, 0, 3]


def test_a_plan_names_them_by_their_axes(tmp_path: Path) -> None:
    steps = (Dwell(3, 20.0), Dwell(SDE, 20.0), Soak(1, 60.0, 13), Dwell(SDE, 20.0, 1))
    write_plan(tmp_path / "plan.toml", steps)
    text = (tmp_path / "plan.toml").read_text()
    assert text.count('axes = "SDE"') == 2
    assert "position = 3" in text
    assert read_plan(tmp_path / "plan.toml") == steps


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('axes = "SDD"', "axes where the cube's x, y, z point"),
        ('axes = "SDW"', "axes where the cube's x, y, z point"),
        ('axes = "SDE"\nposition = 3', "exactly one of position, axes, up and attitude"),
    ],
)
def test_what_is_no_rotation_or_says_two_things_is_refused(tmp_path: Path, line: str, said: str) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(f'format = "plan/1"\n\n[[dwell]]\n{line}\nseconds = 20\n')
    with pytest.raises(DataRefused) as refused:
        read_plan(path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_people_read_and_type_them_by_their_axes(rig: Make) -> None:
    guided = rig(dwells(1, SDE))
    steps = guided.view.steps
    assert files_as_steps("dwell_20.mcap and dwell_20_repeat") == "position SDE and position SDE repeated"
    assert [step_typed(typed, steps) for typed in ("1", "SDE", "position sde")] == [
        "dwell_01", "dwell_20", "dwell_20",
    ]  # fmt: skip
    assert step_title(Dwell(SDE, 1.0)) == "position SDE"
    assert (faces(SDE)["D"], faces(SDE)["S"], faces(SDE)["E"]) == ("+Y", "+X", "+Z")
    assert GridCursor(steps).places == {"dwell_01": (0, 0), "dwell_20": (2, 0)}


def test_a_campaign_of_flips_is_guided_recorded_and_resumed(rig: Make) -> None:
    guided = rig(dwells(SDE, 13, seconds=20.0))
    assert "position SDE: X south, Y down, Z east" in instruction(guided.context.checklist.steps[0])
    guided.hands(f"place {SDE} 8")
    guided.run(guided.done(1))
    assert guided.texts[-1] == "accepted: accepted: position SDE, 1 of 2 done"
    guided.hands("place 13 8")
    guided.run(guided.done(2))
    assert 'axes = "SDE"' in (guided.folder / "campaign.toml").read_text()
    read = read_campaign(guided.folder).campaign
    assert [dwell.position for dwell in read.dwells] == [SDE, 13]
    assert [(move.before, move.after) for move in read.moves] == [("dwell_20.mcap", "dwell_13.mcap")]
    guided.resume()
    assert guided.guide.is_complete
    assert [each.position for each in guided.context.accepted_dwells.values()] == [SDE, 13]


def test_a_heading_a_quarter_off_is_told_by_the_way_to_turn(rig: Make) -> None:
    guided = rig(dwells(SDE, seconds=60.0))
    face = face_of(SDE)
    own = next(q for q in range(4) if turned_position(face, q) == SDE)
    guided.hands(f"place {turned_position(face, (own + 3) % 4)} 8")
    guided.run(lambda v: any(e.sound == "rejected" for e in v.events))
    said = guided.texts[-1]
    assert "90 deg" in said
    assert "counter-clockwise" in said
    assert "position SDE" in said
    guided.hands(f"place {turned_position(face, (own + 2) % 4)} 8")
    guided.run(lambda v: "180 deg" in v.events[-1].text)
    guided.hands(f"place {SDE} 8")
    guided.run(guided.done(1))


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
