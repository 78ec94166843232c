"""A face that stood once is said, with what leans on it, and so are dwells that nothing checks."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.calibration.lone_faces import beside_askew_warnings, lone_face_warnings
from procedures.campaign.campaign import Campaign, RestRecord

TRUTH = Truth.example(7)


def campaign_of(*positions: int) -> Campaign:
    return simulate_campaign(TRUTH, 3, dwell_s=4.0, positions=positions, turns=())


def test_a_face_that_stood_once_is_in_the_solution_s_warnings() -> None:
    found = solve([campaign_of(1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12)]).warnings
    (said,) = (text for text in found if "alone" in text)
    assert said.startswith("alone with their face up: position 3; ")
    assert "misalignment yx, zx leans" in said


def test_faces_that_stood_twice_say_nothing() -> None:
    assert not lone_face_warnings([campaign_of(*range(1, 13))])
    six = campaign_of(1, 3, 5, 7, 9, 11)
    assert not lone_face_warnings([six, six])
    assert lone_face_warnings([six])


def test_another_cube_s_dwell_is_no_second_one() -> None:
    six = campaign_of(1, 3, 5, 7, 9, 11)
    other = replace(six, fixture=replace(six.fixture, id="another"))
    assert "1, 3, 5, 7, 9, 11;" in lone_face_warnings([six, other])[0]


def test_a_rest_with_the_face_up_is_a_second_one() -> None:
    six = campaign_of(1, 3, 5, 7, 9, 11)
    rest = RestRecord("rest", "x_up", six.dwells[0].series)
    assert "positions 3, 5, 7, 9, 11;" in lone_face_warnings([replace(six, rests=(rest,))])[0]


def test_the_axis_is_the_sensor_s_where_the_unit_sits_turned_in_the_cube() -> None:
    campaign = campaign_of(1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12)
    turned = replace(campaign.fixture, C_sb=np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]))  # cube x is sensor z
    assert "misalignment xz, yz leans" in lone_face_warnings([replace(campaign, fixture=turned)])[0]


def test_a_dwell_whose_seat_was_taken_off_leaves_the_other_of_its_face_alone() -> None:
    campaign = campaign_of(1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12)
    assert not beside_askew_warnings([campaign], [])
    names = {dwell.position: dwell.name for dwell in campaign.dwells}
    (said,) = beside_askew_warnings([campaign], [(0, names[7])])
    assert said.startswith("alone with their face up: position 8; the other dwell of the face stood askew")
    assert "misalignment xy, zy leans" in said
    assert not beside_askew_warnings([campaign], [(0, names[3])])  # alone, and nobody else's second
    assert not beside_askew_warnings([campaign, campaign], [(1, names[7])])


def test_as_many_dwells_as_unknowns_are_said_to_be_unchecked() -> None:
    def said(campaign: Campaign) -> list[str]:
        return [text for text in solve([campaign]).warnings if "nothing checks them" in text]

    assert said(campaign_of(1, 3, 5, 7, 9, 11))[0].startswith("accelerometer: its 6 dwells tell hardly more")
    nine = campaign_of(1, 2, 3, 5, 6, 7, 9, 10, 11)
    assert not said(nine)
    turn_ons = [1, 1, 2, 2, 3, 3, 4, 4, 5]
    dwells = tuple(replace(dwell, turn_on=on) for dwell, on in zip(nine.dwells, turn_ons, strict=True))
    assert said(replace(nine, dwells=dwells))
