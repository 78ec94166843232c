"""The drawing of the cube, against the rotations the solve uses."""

import re

import numpy as np
import pytest

from procedures.frames import nominal_C_lb
from station.guide.view import Step
from station.tui.cube_picture import LARGE, SMALL, Size, axis_colour, cube_picture
from station.tui.orientation import faces, in_words, instruction, is_counter_clockwise, sense, start_of
from tests.station.tui.views import PLACING, REDOING, TURNING

TOWARDS = {"east": (1, 0, 0), "north": (0, 1, 0), "up": (0, 0, 1), "west": (-1, 0, 0), "south": (0, -1, 0),
           "down": (0, 0, -1)}  # fmt: skip
every_position = pytest.mark.parametrize("position", range(1, 13))


def face_towards(position: int, way: str) -> str:
    """Return the signed body axis that points a way, from the rotation."""
    along = nominal_C_lb(position).T @ np.array(TOWARDS[way], float)
    axis = int(np.argmax(np.abs(along)))
    return f"{'+' if along[axis] > 0 else '-'}{'XYZ'[axis]}"


@every_position
@pytest.mark.parametrize("size", [SMALL, LARGE], ids=["small", "large"])
def test_every_label_of_the_drawing_is_the_axis_that_points_there(position: int, size: Size) -> None:
    rows = cube_picture(faces(position), size).plain.split("\n")
    assert all(len(row) == size.columns for row in rows)
    for way in ("north", "west", "down"):  # hidden faces: by name in the legend
        assert re.search(rf"{way} +([+-][XYZ])", "\n".join(rows))[1] == face_towards(position, way)
    drawn = [row[: size.legend_column] for row in rows]
    for way in ("up", "south", "east"):  # the label stands right above its word
        at = next(i for i, row in enumerate(drawn) if way in row)
        column = drawn[at].index(way)
        above = drawn[at - 1][max(column - 2, 0) : column + len(way) + 2]
        assert re.findall("[+-][XYZ]", above) == [face_towards(position, way)]
    top, front, side = (place_of(drawn, face_towards(position, way)) for way in ("up", "south", "east"))
    assert top[0] < size.depth < front[0]  # the top is above the front's upper edge
    assert front[1] < size.corner < side[1]  # the east face is right of the front's right edge


def place_of(rows: list[str], label: str) -> tuple[int, int]:
    return next((i, row.index(label)) for i, row in enumerate(rows) if label in row)


@every_position
def test_the_faces_are_those_of_the_rotation_in_words_too(position: int) -> None:
    looks = faces(position)
    assert sorted(looks.values()) == ["+X", "+Y", "+Z", "-X", "-Y", "-Z"]
    for way in TOWARDS:
        assert looks[way[0].upper()] == face_towards(position, way)
    for axis, way in re.findall(r"(\+[XYZ]) (\w+)", in_words(position)):
        assert face_towards(position, way) == axis


def test_each_face_has_the_colour_of_its_axis() -> None:
    styles = {str(span.style) for span in cube_picture(faces(1), SMALL).spans}  # X up, -Z south, Y east
    assert any("$axis-x 60%" in style for style in styles)
    assert any("$axis-z 42%" in style for style in styles)
    assert any("$axis-y 26%" in style for style in styles)
    assert axis_colour("-Z") == "$axis-z"


@pytest.mark.parametrize("step", [step for step in TURNING.steps if step.axis], ids=lambda step: step.name)
def test_the_arrow_of_a_turn_shows_how_the_front_moves(step: Step) -> None:
    up = nominal_C_lb(start_of(step)) @ np.eye(3)["xyz".index(step.axis)]
    assert up == pytest.approx([0, 0, 1])
    rate = up if step.direction == "+" else -up
    front_moves = np.cross(rate, TOWARDS["south"])[0]  # towards the east, which is right in the drawing
    assert is_counter_clockwise(step) == (front_moves > 0)
    turn = "counter-clockwise" if is_counter_clockwise(step) else "clockwise"
    last = cube_picture(faces(start_of(step)), SMALL, turn).plain.split("\n")[-1]
    assert ("▶" in last, "◀" in last) == (front_moves > 0, front_moves < 0)
    assert f"3 turns {turn} seen from above" == sense(step)


def test_a_turn_of_a_plan_may_be_about_an_axis_that_points_down() -> None:
    down = Step(name="t", state="todo", axis="x", direction="+", revolutions=1, start_position=3)
    assert sense(down) == "1 turn clockwise seen from above"


def test_the_instruction_names_position_and_axes() -> None:
    assert instruction(PLACING.step("dwell_03")) == "position 3: +X down, +Y north, +Z east"
    assert instruction(REDOING.step("turn_x_minus")) == "turn X -: 3 turns clockwise seen from above"
