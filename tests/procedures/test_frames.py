import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from procedures.frames import rotation, slab_C_ln, vertical_rotation
from procedures.positions import (
    FACES,
    TURN_START,
    C_bn,
    cross_axes,
    face_normal,
    face_of,
    face_rotation,
    nominal_C_lb,
)
from tests.procedures.independent import TABLE_1, body_from_level

every_position = pytest.mark.parametrize("position", range(1, 13))
every_face = pytest.mark.parametrize("face", FACES)
small = st.floats(-1e-2, 1e-2)
EXACT = 1e-15


@every_position
def test_the_nominal_attitudes_are_table_1_and_right_handed(position: int) -> None:
    C = nominal_C_lb(position)
    assert np.array_equal(C.T, body_from_level(position))
    assert np.linalg.det(C) == pytest.approx(1, abs=EXACT)
    assert np.array_equal(np.cross(C[:, 0], C[:, 1]), C[:, 2])


@every_position
def test_the_up_letter_names_the_face(position: int) -> None:
    letters = TABLE_1[position - 1]
    axis = next(i for i in range(3) if letters[i] in "UD")
    assert face_of(position) == f"{'xyz'[axis]}_{'up' if letters[axis] == 'U' else 'down'}"
    assert np.array_equal(face_normal(face_of(position)), body_from_level(position)[:, 2])


def test_partners_are_the_same_face_turned_by_half_a_turn() -> None:
    for first in range(1, 13, 2):
        half_turn = np.diag([-1.0, -1.0, 1.0])
        assert np.array_equal(nominal_C_lb(first + 1), half_turn @ nominal_C_lb(first))


def test_turns_start_with_their_axis_up() -> None:
    for axis, position in TURN_START.items():
        assert face_of(position) == f"{axis}_up"


@given(st.lists(st.floats(-4, 4), min_size=3, max_size=3))
def test_rotation_is_the_exponential_map(vector: list[float]) -> None:
    expected = Rotation.from_rotvec(vector).as_matrix()
    assert np.max(np.abs(rotation(np.array(vector)) - expected)) < 1e-14


def test_rotations_are_made_all_at_once() -> None:
    vectors = np.random.default_rng(1).standard_normal((4, 2, 3))
    assert np.array_equal(rotation(vectors)[3, 1], rotation(vectors[3, 1]))
    assert np.array_equal(rotation(np.zeros(3)), np.eye(3))


@given(small, small)
def test_the_slab_sees_up_tilted_as_its_tilt_says(east: float, north: float) -> None:
    up = slab_C_ln(np.array([east, north])) @ [0, 0, 1]
    assert np.abs(up[:2] - [east, north]).max() <= np.hypot(east, north) ** 3 + EXACT  # sin x = x - x^3 / 6
    assert up[2] > 0


@every_face
@given(first=small, second=small)
def test_a_face_tilt_is_where_the_slab_normal_points_in_the_cube(face: str, first: float, second: float) -> None:
    C = face_rotation(face, np.array([first, second]))
    seen = C @ face_normal(face)
    tilt = np.hypot(first, second)
    assert np.abs(seen[list(cross_axes(face))] - [first, second]).max() <= tilt**3 + EXACT
    assert seen @ face_normal(face) == pytest.approx(np.cos(tilt), abs=1e-12)
    assert np.linalg.det(C) == pytest.approx(1, abs=1e-12)


@every_face
def test_a_face_tilt_adds_no_twist_about_the_vertical(face: str) -> None:
    vector = Rotation.from_matrix(face_rotation(face, np.array([3e-3, -2e-3]))).as_rotvec()
    assert abs(vector @ face_normal(face)) < EXACT


def test_headings_are_counter_clockwise_seen_from_above() -> None:
    assert vertical_rotation(np.pi / 2) @ [1, 0, 0] == pytest.approx([0, 1, 0])
    # position 1 has its Y to the East: turned counter-clockwise by 90 deg it points North
    C = C_bn(1, np.zeros(2), np.zeros(2), np.pi / 2)
    assert C.T @ [0, 1, 0] == pytest.approx([0, 1, 0])
    assert C.T @ [1, 0, 0] == pytest.approx([0, 0, 1])


@every_position
def test_the_cube_is_tilted_after_the_slab(position: int) -> None:
    """Independently: up in the slab's marks, then along the letters, then the face's tilt."""
    rng = np.random.default_rng(position)
    slab, face, heading = 1e-5 * rng.standard_normal(2), 1e-5 * rng.standard_normal(2), 0.3
    up = C_bn(position, slab, face, heading) @ [0, 0, 1]
    c, s = np.cos(heading), np.sin(heading)
    level = np.array([c * slab[0] + s * slab[1], c * slab[1] - s * slab[0], 1.0])
    expected = body_from_level(position) @ level
    expected[list(cross_axes(face_of(position)))] += face
    assert np.abs(up - expected).max() < 1e-9  # squares of the tilts
