"""A face that stood once is said, with what leans on it, and so are dwells that nothing checks."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.calibration.lone_faces import beside_askew_warnings, lone_face_warnings
from procedures.campaign.campaign import Campaign, MoveRecord, RestRecord

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


def test_moves_from_or_to_it_make_the_gyroscope_lean_on_it_too() -> None:
    campaign = campaign_of(1, 2, 3, 5, 6)  # 3 is alone
    first, second, third, *_ = (dwell.name for dwell in campaign.dwells)
    series = campaign.dwells[0].series
    (said,) = lone_face_warnings([replace(campaign, moves=(MoveRecord("a", second, third, series),))])
    assert "yx, zx leans on it, as do gyroscope scale factor and misalignment by the moves from and to it;" in said
    (said,) = lone_face_warnings([replace(campaign, moves=(MoveRecord("b", first, second, series),))])
    assert "gyroscope" not in said


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


def unchecked(campaign: Campaign) -> list[str]:
    return [text.split(":")[0] for text in solve([campaign]).warnings if "nothing checks" in text]


def test_of_as_many_dwells_as_unknowns_nothing_checks_any() -> None:
    assert unchecked(campaign_of(1, 3, 5, 7, 9, 11)) == ["nothing checks positions 1, 3, 5, 7, 9, 11"]
    assert unchecked(campaign_of(*range(1, 13))) == []


def test_two_faces_in_a_turn_on_of_their_own_are_checked_by_no_other() -> None:
    """However the cube stands in one of them: it is that turn-on's bias and a misalignment."""
    seven = simulate_campaign(
        TRUTH, 3, dwell_s=4.0, positions=(1, 4, 5, 6, 8, 10, 11), turns=(), certificate_sigma=5e-6
    )
    assert unchecked(seven) == []
    dwells = tuple(replace(dwell, turn_on=1 + (dwell.position > 8)) for dwell in seven.dwells)
    assert unchecked(replace(seven, dwells=dwells)) == ["nothing checks positions 10, 11"]


def test_a_dwell_alone_in_its_turn_on_is_leant_on_by_nothing_else() -> None:
    """As the first position once more, after the unit was switched off: it tells its own biases."""
    twelve = campaign_of(*range(1, 13))
    last = replace(twelve.dwells[0], name="dwell_01_repeat", turn_on=2)
    assert unchecked(replace(twelve, dwells=(*twelve.dwells, last))) == []
