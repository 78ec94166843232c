"""The drawing of the cube, against the rotations the solve uses."""

import re

import numpy as np
import pytest
from textual.content import Content

from procedures.arrays import FloatArray
from procedures.frames import vertical_rotation
from procedures.positions import nominal_C_lb
from station.guide.view import StepView
from station.tui.widgets.common import Canvas
from station.tui.widgets.cube import (
    LARGE,
    SMALL,
    PictureSize,
    draw_cube,
    draw_turned,
    faces,
    faces_of,
    is_counter_clockwise,
    start_of,
)
from tests.station.tui import views
from tests.station.tui.session import LARGE as LARGE_TERMINAL
from tests.station.tui.session import screens
from tests.station.tui.views import TURNING

TOWARDS = {"east": (1, 0, 0), "north": (0, 1, 0), "up": (0, 0, 1), "west": (-1, 0, 0), "south": (0, -1, 0),
           "down": (0, 0, -1)}  # fmt: skip
every_position = pytest.mark.parametrize("position", range(1, 13))


def drawn_cube(looks: dict[str, str], size: PictureSize, turn: str = "") -> Content:
    canvas = Canvas(size.columns, size.rows)
    draw_cube(canvas, looks, size, turn)
    return canvas.content()


def rows_of(C_lb: FloatArray) -> list[list[float]]:
    rows: list[list[float]] = C_lb.tolist()
    return rows


def face_towards(position: int, way: str) -> str:
    """Return the signed body axis that points a way, from the rotation."""
    along = nominal_C_lb(position).T @ np.array(TOWARDS[way], float)
    axis = int(np.argmax(np.abs(along)))
    return f"{'+' if along[axis] > 0 else '-'}{'XYZ'[axis]}"


@every_position
@pytest.mark.parametrize("size", [SMALL, LARGE], ids=["small", "large"])
def test_every_label_of_the_drawing_is_the_axis_that_points_there(position: int, size: PictureSize) -> None:
    rows = drawn_cube(faces(position), size).plain.split("\n")
    assert all(len(row) == size.columns for row in rows)
    for way in ("north", "west", "down"):  # hidden faces: named in the last line
        named = re.search(rf"(?:{way}|\b{way[0].upper()}) ([+-][XYZ])", rows[-1])
        assert named[1] == face_towards(position, way)
    drawn = rows[:-1]
    place = {way: place_of(drawn, face_towards(position, way)) for way in ("up", "south", "east")}
    assert place["up"][0] < size.depth < place["south"][0]  # the top is above the front's upper edge
    assert place["south"][1] < size.corner < place["east"][1]  # the east face is right of the front's right edge
    for way in ("up", "south", "east" if size is LARGE else "E"):  # next to its label, or right below it
        near = drawn[place[way.replace("E", "east")][0]] + drawn[place[way.replace("E", "east")][0] + 1]
        assert way in near


def place_of(rows: list[str], label: str) -> tuple[int, int]:
    return next((i, row.index(label)) for i, row in enumerate(rows) if label in row)


@every_position
def test_the_faces_are_those_of_the_rotation(position: int) -> None:
    looks = faces(position)
    assert sorted(looks.values()) == ["+X", "+Y", "+Z", "-X", "-Y", "-Z"]
    for way in TOWARDS:
        assert looks[way[0].upper()] == face_towards(position, way)


@every_position
@pytest.mark.parametrize("size", [SMALL, LARGE], ids=["small", "large"])
def test_a_cube_drawn_at_any_attitude_has_its_labels_where_its_faces_are(position: int, size: PictureSize) -> None:
    """Turned by 15 deg clockwise all three faces still look up, south and east."""
    canvas = Canvas(size.columns, size.rows)
    draw_turned(canvas, rows_of(vertical_rotation(np.radians(-15.0)) @ nominal_C_lb(position)), size)
    rows = canvas.content().plain.split("\n")
    up, south, east = (place_of(rows, face_towards(position, way)) for way in ("up", "south", "east"))
    assert up[0] < min(south[0], east[0])
    assert south[1] < east[1]
    assert faces_of(rows_of(vertical_rotation(np.radians(-15.0)) @ nominal_C_lb(position))) is None


def test_a_cube_at_any_attitude_stays_in_its_picture_and_shows_no_hidden_face() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        C_lb = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        C_lb *= np.linalg.det(C_lb)
        canvas = Canvas(LARGE.columns, LARGE.rows)
        draw_turned(canvas, rows_of(C_lb), LARGE)
        shown = re.findall("[+-][XYZ]", canvas.content().plain)
        view = np.array([LARGE.depth / (LARGE.width + 1), -1.0, LARGE.depth / (LARGE.height + 1)])
        for name in shown:
            normal = C_lb[:, "XYZ".index(name[1])] * (1 if name[0] == "+" else -1)
            assert normal @ view > 0
        assert shown


@pytest.mark.parametrize("step", [step for step in TURNING.steps if step.axis], ids=lambda step: step.name)
def test_the_arrow_of_a_turn_shows_how_the_front_moves(step: StepView) -> None:
    up = nominal_C_lb(start_of(step)) @ np.eye(3)["xyz".index(step.axis)]
    assert up == pytest.approx([0, 0, 1])
    rate = up if step.direction == "+" else -up
    front_moves = np.cross(rate, TOWARDS["south"])[0]  # towards the east, which is right in the drawing
    assert is_counter_clockwise(step) == (front_moves > 0)
    turn = "counter-clockwise" if is_counter_clockwise(step) else "clockwise"
    lower_edge = drawn_cube(faces(start_of(step)), SMALL, turn).plain.split("\n")[SMALL.bottom]
    assert ("▶" in lower_edge, "◀" in lower_edge) == (front_moves > 0, front_moves < 0)


@pytest.mark.parametrize("size", [(80, 24), LARGE_TERMINAL], ids=["80x24", "120x40"])
async def test_the_cube_as_it_stands_is_drawn_next_to_the_cube_as_wanted(size: tuple[int, int]) -> None:
    async with screens(views.TURN_IT, size) as seen:
        await seen.pilot.pause()
        reported = "\n".join(seen.lines())
        assert re.search(r"TARGET +CUBE NOW", reported)
        assert "turn 176 deg more, clockwise" in " ".join(reported.split())
        assert reported.count("-X") >= 2  # up in both ...
        assert "-Y" in reported  # ... but the front of one is the back of the other
        small = seen.app.screen.cube.size.width
    assert small == 38 or size != (80, 24)


async def test_a_heading_that_is_not_known_is_not_drawn() -> None:
    async with screens(views.UNKNOWN) as seen:
        await seen.pilot.pause()
        half = [line[19:38] for line in seen.lines()[4:16]]  # of the cube as it stands
        assert set(re.findall("[+-][XYZ]", "".join(half))) == {"-X", "+X"}
        assert "?" in "".join(half)
        assert "its heading is not known yet" in "\n".join(seen.lines())


async def test_nothing_is_drawn_of_a_cube_that_nobody_sees() -> None:
    async with screens(views.SILENT) as seen:
        await seen.pilot.pause()
        assert not re.findall("[+-][XYZ]", "".join(line[19:38] for line in seen.lines()[4:16]))
        gates = seen.app.screen.gates.render().plain
        assert "✓" not in gates
        assert gates.count("not checked now") == 2
