"""Positions beyond the twelve, named by where the cube's axes point, and repeated ones."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from procedures.campaign.plan_steps import Dwell, Soak, as_repeats
from procedures.frames import vertical_rotation
from procedures.gyrocompass import quarters_to, turned_position
from procedures.positions import ATTITUDES, FACES, face_of, nominal_C_lb
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_file import read_plan, write_plan
from station.files.campaign_setup import Setup
from station.guide.campaign.campaign_start import usual_steps
from station.guide.wording import instruction
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
    ("line", "reported"),
    [
        ('axes = "SDD"', "axes where the cube's x, y, z point"),
        ('axes = "SDW"', "axes where the cube's x, y, z point"),
        ('axes = "SDE"\nposition = 3', "exactly one of position, axes, up and attitude"),
    ],
)
def test_what_is_no_rotation_or_says_two_things_is_refused(tmp_path: Path, line: str, reported: str) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(f'format = "plan/1"\n\n[[dwell]]\n{line}\nseconds = 20\n')
    with pytest.raises(DataRefused) as refused:
        read_plan(path)
    assert reported in str(refused.value)
    assert "\n" not in str(refused.value)


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


def files(guided: GuideRig) -> list[str]:
    return [dwell.name for dwell in read_campaign(guided.folder).campaign.dwells]


def test_the_usual_plan_ends_as_it_began_unless_it_is_specified_otherwise() -> None:
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
        guided.execute("redo", step=redone)
        guided.hands("place 1 8")
        guided.run(lambda v, name=redone: v.step(name).attempts == 2)
        assert files(guided) == left
    guided.resume()
    assert {step.name: step.attempts for step in guided.view.steps} == {
        "dwell_01": 2, "dwell_02": 1, "dwell_01_repeat": 2,
    }  # fmt: skip
