"""Dwells on another face than their position names, and IMUs mounted otherwise than said: named, never guessed."""

import re
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.bench.position_checks import heading_errors, refuse_wrong_faces
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Fixture
from procedures.errors import WrongFace, WrongMounting
from procedures.geodesy import EARTH_RATE
from procedures.gyrocompass import CertainDwell
from procedures.positions import POSITIONS, face_of
from procedures.units import RAD_S_PER_DEG_H
from tests.procedures.calibration.simulated_campaigns import fine, scores, simulated, usual
from tests.procedures.independent import body_from_level, dwells
from tests.refusals import refused


def nominal_rates(positions: list[int], C_sb: FloatArray) -> FloatArray:
    """Raw outputs of a misaligned, biased unit in these positions."""
    E = np.eye(3) + 5e-3 * np.random.default_rng(1).standard_normal((3, 3))
    u = np.array([C_sb @ body_from_level(p)[:, 2] for p in positions])
    return np.array([1000.0, 990.0, 1010.0]) * (u @ E.T + [2e-3, -1e-3, 3e-3])


@pytest.mark.parametrize("wrong", [pytest.param(p * (p in {5, 6, 7, 8})) for p in range(1, 13)])
def test_one_wrong_label_is_named_with_both_faces(wrong: int) -> None:
    rate = nominal_rates(list(range(1, 13)), np.eye(3))
    for named in range(1, 13):
        if face_of(named) == face_of(wrong):
            continue
        labels = list(range(1, 13))
        labels[wrong - 1] = named
        with pytest.raises(WrongFace) as caught:
            refuse_wrong_faces(dwells(rate, 1e-3, labels), [np.eye(3)])
        assert (caught.value.position, caught.value.named, caught.value.seen) == (
            named,
            face_of(named),
            face_of(wrong),
        )
        assert caught.value.step == f"dwell_{named:02d}"


@pytest.mark.parametrize("output_per_g", [1e-4, 1.0])
def test_a_wrong_label_is_named_whatever_the_unit_of_the_output(output_per_g: float) -> None:
    rate = output_per_g / 1000.0 * nominal_rates(list(range(1, 13)), np.eye(3))
    with pytest.raises(WrongFace):
        refuse_wrong_faces(dwells(rate, 1e-6 * output_per_g, [5, *range(2, 13)]), [np.eye(3)])


def test_outputs_that_never_change_contradict_no_label() -> None:
    refuse_wrong_faces(dwells(np.ones((12, 3)), 1e-3, list(range(1, 13))), [np.eye(3)])


def test_a_wrong_label_is_refused_by_solve_and_named_by_its_file() -> None:
    _, campaign = usual()
    steps = list(campaign.dwells)
    steps[3] = replace(steps[3], position=5)
    with refused(WrongFace, step="dwell_04", position=5, named="y_up", seen="x_down"):
        solve([replace(campaign, dwells=tuple(steps))])


@pytest.mark.parametrize(
    "positions",
    [
        [1, 3, 5, 9],
        [1, 3],
        [1],
        [1, 2, 3, 4],
        [1, 3, 5, 7, 9, 11],
        [2, 6, 10, 12],
        list(range(1, 12)),
        [1, 1, 1, 5],
    ],
)
@pytest.mark.parametrize("C_sb", [np.eye(3), np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])])
def test_correct_labels_are_never_refused(positions: list[int], C_sb: FloatArray) -> None:
    refuse_wrong_faces(dwells(nominal_rates(positions, C_sb), 1e-3, positions), [C_sb])


@pytest.mark.parametrize(
    "axes",
    [
        ("+y", "-x", "+z"),
        pytest.param(("-x", "-y", "+z")),
        ("+z", "+x", "+y"),
        ("-y", "+z", "-x"),
    ],
)
def test_a_wrong_mounting_is_named(axes: tuple[str, str, str]) -> None:
    truth = replace(fine(9), imu_axes=axes)
    campaign = simulated(truth, 9, turns=())
    with refused(WrongMounting, seen=str(list(axes))):
        solve([replace(campaign, fixture=Fixture())])
    assert np.abs(scores(solve([campaign]), truth)).max() < 4


# Headings that are off, by the Earth's rate


LATITUDE, K = np.radians(31.17), 2e6  # rad, count/rad
NOISE = 0.036 * RAD_S_PER_DEG_H  # rad/s, 100 s of 1e-4 deg/sqrt(s)
HEADING = float(np.radians(0.1))


def sees(position: int, heading: float) -> FloatArray:
    """The Earth's rate along X, Y, Z of a cube turned by ``heading`` counter-clockwise from a position."""
    north, up = EARTH_RATE * np.cos(LATITUDE), EARTH_RATE * np.sin(LATITUDE)
    bearing = {"N": 0.0, "W": np.pi / 2, "S": np.pi, "E": -np.pi / 2}  # counter-clockwise from North
    along = {"U": up, "D": -up} | {one: north * np.cos(angle + heading) for one, angle in bearing.items()}
    return np.array([along[letter] for letter in POSITIONS[position - 1]])


def campaign(
    seed: int,
    off_deg: dict[int, float],
    positions: range = range(1, 13),
    noise: float = NOISE,
    azimuth: float = 0.0,
) -> list[CertainDwell]:
    rng = np.random.default_rng(seed)
    k = K * (1 + 0.01 * rng.standard_normal(3))
    E, b = np.eye(3) + 7e-4 * rng.standard_normal((3, 3)), RAD_S_PER_DEG_H * rng.standard_normal(3)
    dwells = []
    for position in positions:
        heading = azimuth + HEADING * rng.standard_normal() + np.radians(off_deg.get(position, 0.0))
        rate = k * (E @ sees(position, heading) + b + noise * rng.standard_normal(3))
        dwells.append(CertainDwell(position, rate, k * noise))
    return dwells


def found(dwells: list[CertainDwell]) -> list[tuple[list[int], float]]:
    errors = heading_errors(dwells, LATITUDE, np.eye(3), K * np.eye(3), HEADING)
    return [([dwells[i].position for i in one.dwells], float(np.degrees(one.angle))) for one in errors]


@pytest.mark.parametrize("off", [4.0, -2.5])
@pytest.mark.parametrize("position", [1, 7, 12])
def test_a_position_that_stood_off_is_named_with_its_angle(position: int, off: float) -> None:
    [(named, angle)] = found(campaign(position, {position: off}))
    assert named == [position]
    assert angle == pytest.approx(off, abs=0.8)
    [error] = heading_errors(campaign(position, {position: off}), LATITUDE, np.eye(3), K * np.eye(3), HEADING)
    assert abs(np.degrees(error.angle) - off) < 4 * np.degrees(np.hypot(error.std, HEADING))


def test_headings_as_good_as_stated_are_left_alone_also_where_the_marks_point_elsewhere() -> None:
    false = [found(campaign(seed, {}, azimuth=np.radians(2.0 * (seed % 2)))) for seed in range(60)]
    assert sum(map(bool, false)) <= 1


def test_nothing_is_reported_where_the_gyros_cannot_decide() -> None:
    assert [found(campaign(seed, {7: 4.0}, noise=3 * RAD_S_PER_DEG_H)) for seed in range(10)] == [[]] * 10


def test_of_one_face_alone_nothing_is_reported_and_of_few_no_wrong_one_is_named_alone() -> None:
    for seed in range(10):
        assert found(campaign(seed, {2: 4.0}, range(1, 3))) == []
        for named, _ in found(campaign(seed, {6: 4.0}, range(1, 7))):
            assert 6 in named


def solved(seed: int, **effect: dict[str, float]) -> list[str]:
    effects = {name.replace("_", "."): sizes for name, sizes in effect.items()}
    truth = replace(Truth.example(seed), effects=effects)
    return [
        text for text in solve([simulate_campaign(truth, seed, dwell_s=30.0)]).warnings if "heading error" in text
    ]


def test_a_solution_names_the_dwell_that_stood_4_deg_off() -> None:
    [text] = solved(1, placement_dwell={"position": 7.0, "y": float(np.radians(4))})
    reported = re.match(
        r"position 7 \(dwell_07\) has a heading error of (\d\.\d) deg, counter-clockwise from above, by", text
    )
    assert reported
    assert float(reported[1]) == pytest.approx(4.0, abs=0.6)
    assert text.endswith("record it again")
