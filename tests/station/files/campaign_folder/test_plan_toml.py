"""A plan says what is to be done; a kind of step that cannot be guided yet is refused with its line."""

from pathlib import Path

import pytest

from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Turn
from station.errors import DataRefused
from station.files.campaign_folder.plan_toml import read_plan, write_plan

STEPS = (
    Dwell(3, 100.0), FreePosition(1, 60.0), Dwell(1, 20.5), FreePosition(2, 50.0),
    Turn("x", "+", 3, 1, 5.0), Turn("z", "-", 2, 9, 4.0),
    Soak(1, 3600.0, 9), Soak(2, 1800.0, up="x_down"), Soak(3, 900.0),
    Monitor(1, 60.0, 9), Monitor(2, 30.0, 1, ("paper",)),
    Dwell(3, 90.0, 1), Dwell(3, 80.0, 2),
)  # fmt: skip


def refused(path: Path, text: str) -> str:
    path.write_text('format = "plan/1"\n' + text)
    with pytest.raises(DataRefused) as caught:
        read_plan(path)
    return str(caught.value)


def test_a_plan_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.toml", STEPS)
    assert read_plan(tmp_path / "plan.toml") == STEPS
    assert (tmp_path / "plan.toml").read_text().startswith('format = "plan/1"\n\n[[dwell]]\nposition = 3\nseconds')


def test_the_same_keys_as_in_a_campaign_with_seconds(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text("""format = "plan/1"
[[dwell]]
position = 5
seconds = 100
[[turn]]
axis = "y"
direction = "-"
revolutions = 3
""")
    assert read_plan(path) == (Dwell(5, 100.0), Turn("y", "-", 3, 5, 5.0))


def test_a_position_that_comes_again_is_a_repeat_and_done_last(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    again = "[[dwell]]\nposition = 1\nseconds = 9\n"
    turn = '[[turn]]\naxis = "x"\ndirection = "+"\nrevolutions = 3\n'
    path.write_text('format = "plan/1"\n' + again * 2 + "[[dwell]]\nposition = 2\nseconds = 9\n" + turn)
    assert read_plan(path) == (Dwell(1, 9.0), Dwell(2, 9.0), Turn("x", "+", 3, 1, 5.0), Dwell(1, 9.0, 1))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[[dwell]]\nup = "x_up"\nseconds = 9\n', "plan.toml:2: found a [[dwell]] with up = 'x_up'"),
        ("[[sequence]]\nseconds = 9\n", "a [[sequence]]"),
        ('[[rate]]\naxis = "x"\n', "a [[rate]]"),
    ],
)  # fmt: skip
def test_a_step_that_cannot_be_guided_yet_is_refused(tmp_path: Path, text: str, said: str) -> None:
    message = refused(tmp_path / "plan.toml", text)
    assert said in message
    assert "cannot be guided yet" in message


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "found no step"),
        ("[[dwell]]\nposition = 13\nseconds = 9\n", "plan.toml:3: found dwell.position = 13"),
        ("[[dwell]]\nposition = 1\n", "no dwell.seconds"),
        ("[[dwell]]\nseconds = 9\n", "without position"),
        ("[[dwell]]\nposition = 1\nseconds = -9\n", "dwell.seconds = -9"),
        ('[[dwell]]\nposition = 1\nseconds = 9\nfile = "x"\n', "unknown key 'dwell.file'"),
        (
            '[[turn]]\naxis = "x"\ndirection = "+"\nrevolutions = 3\n' * 2,
            "plan.toml:6: found a second turn_x_plus",
        ),
        (
            '[[soak]]\nposition = 1\nup = "x_up"\nseconds = 9\n',
            "plan.toml:2: found a [[soak]] with position and up",
        ),
        ("[[monitor]]\nseconds = 9\n", "no monitor.position"),
        ('[[monitor]]\nposition = 9\nseconds = 9\nlaws = ["kalman"]\n', "monitor.laws"),
        ('[[monitor]]\nposition = 9\nseconds = 9\nlaws = ["paper-filter"]\n', "takes a velocity, found aid none"),
        ('[[monitor]]\nposition = 9\nseconds = 9\nlaws = ["joint", "joint"]\n', "two different ones"),
        ('[[dwell]]\nattitude = "flat"\nseconds = 9\n', "dwell.attitude"),
        ('[[turn]]\naxis = "x"\ndirection = "+"\nrevolutions = 3\nstart_position = 5\n', "one with x up"),
        ("format = 3\n", "no TOML"),
        ("[[", "no TOML"),
    ],
)
def test_what_is_no_plan_is_refused_with_its_line(tmp_path: Path, text: str, said: str) -> None:
    assert said in refused(tmp_path / "plan.toml", text)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataRefused, match="no readable file"):
        read_plan(tmp_path / "plan.toml")
