"""A plan says what is to be done; a kind of step that cannot be guided yet is refused with its line."""

from pathlib import Path

import pytest

from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Turn
from station.errors import DataRefused
from station.files.campaign_folder.plan_file import read_plan, write_plan
from tests.refusals import refused

STEPS = (
    Dwell(3, 100.0), FreePosition(1, 60.0), Dwell(1, 20.5), FreePosition(2, 50.0),
    Turn("x", "+", 3, 1, 5.0), Turn("z", "-", 2, 9, 4.0),
    Soak(1, 3600.0, 9), Soak(2, 1800.0, up="x_down"), Soak(3, 900.0),
    Monitor(1, 60.0, 9), Monitor(2, 30.0, 1, ("paper",)),
    Dwell(3, 90.0, 1), Dwell(3, 80.0, 2),
)  # fmt: skip


def test_a_plan_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.toml", STEPS)
    assert read_plan(tmp_path / "plan.toml") == STEPS
    assert (tmp_path / "plan.toml").read_text().startswith('format = "plan/1"\n\n[[dwell]]\nposition = 3\nseconds')


def test_a_position_that_comes_again_is_a_repeat_and_done_last(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    again = "[[dwell]]\nposition = 1\nseconds = 9\n"
    turn = '[[turn]]\naxis = "x"\ndirection = "+"\nrevolutions = 3\n'
    path.write_text('format = "plan/1"\n' + again * 2 + "[[dwell]]\nposition = 2\nseconds = 9\n" + turn)
    assert read_plan(path) == (Dwell(1, 9.0), Dwell(2, 9.0), Turn("x", "+", 3, 1, 5.0), Dwell(1, 9.0, 1))


DWELL, TURN = "[[dwell]]\nposition = 1\nseconds = 9\n", '[[turn]]\naxis = "x"\ndirection = "+"\nrevolutions = 3\n'


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('[[dwell]]\nup = "x_up"\nseconds = 9\n', 2), ("[[sequence]]\nseconds = 9\n", 2),
        ('[[rate]]\naxis = "x"\n', 2),
        ("", None), (DWELL.replace("1", "13"), 3), ("[[dwell]]\nposition = 1\n", 2), (DWELL.replace("9", "-9"), 4),
        (DWELL + 'file = "x"\n', 5), (2 * TURN, 6), ('[[soak]]\nposition = 1\nup = "x_up"\nseconds = 9\n', 2),
        ("[[monitor]]\nseconds = 9\n", 2), ('[[monitor]]\nposition = 9\nseconds = 9\nlaws = ["kalman"]\n', 5),
        ('[[monitor]]\nposition = 9\nseconds = 9\nlaws = ["joint", "joint"]\n', None),
        (TURN + "start_position = 5\n", None), ("format = 3\n", 2), ("[[", None),
    ],
)  # fmt: skip
def test_what_is_no_plan_or_cannot_be_guided_is_refused_with_its_line(
    tmp_path: Path, text: str, line: int | None
) -> None:
    (tmp_path / "plan.toml").write_text('format = "plan/1"\n' + text)
    with refused(DataRefused) as found:
        read_plan(tmp_path / "plan.toml")
    assert line is None or found.value.line == line
