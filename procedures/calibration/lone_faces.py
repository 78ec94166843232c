"""What a solution says of faces of the cube that stood once: no second dwell shows whether they stood clean.

A cube that leans in the only dwell of a face is to the level sensors half a misalignment and half a bias. Other
faces know the biases, but in dwells of some seconds not to the last arcseconds, and they do not tell which seat it
was. The sigma holds the seat's 1 sigma as it is stated, and no more.
"""

from collections import Counter
from collections.abc import Collection, Sequence

import numpy as np

from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.dwells_and_turns.twelve_position import TriadFit
from procedures.frames import AXES, face_normal, face_of, position_name

LEAST_FREE = 0.01  # share of a rate's variance that the fit must leave for a slip to show in it


def lone_face_warnings(campaigns: Sequence[Campaign]) -> list[str]:
    """Say which positions were alone with their face up, and what leans on them; nothing if all faces stood twice.

    Campaigns with the same cube count together; those whose cube has no name are taken for one cube's.
    """
    return _said(_alone(campaigns), "no second dwell", "record the other position of the face too")


def beside_askew_warnings(campaigns: Sequence[Campaign], askew: Collection[tuple[int, str]]) -> list[str]:
    """Say which positions are alone because the other dwell of their face stood askew.

    ``askew`` are the number of the campaign and the name of each dwell whose seat was found: it is taken off, and
    says nothing more of how the face lies.
    """
    before = _alone(campaigns)
    lone = [each for each in _alone(campaigns, askew) if each not in before]
    why = "the other dwell of the face stood askew, and no second one"
    return _said(lone, why, "record the other position of the face again")


def unchecked_warnings(accelerometer: TriadFit) -> list[str]:
    """Say which positions nothing checks: all that their dwells tell is taken by what is solved of them.

    So it is of a face that stood once in a turn-on whose biases no other face tells, and of six dwells on a cube
    without certificate. The residual is then nought however the cube stood (redundancy numbers: Baarda, A testing
    procedure for use in geodetic networks, 1968). A dwell alone in its turn-on tells that one's biases; nothing
    else leans on it.
    """
    dwells = accelerometer.seen.dwells
    stood = Counter((number, dwell.turn_on) for number, dwell in dwells)
    taken = [dwells[i] for i in np.flatnonzero((accelerometer.free < LEAST_FREE).all(axis=1))]
    leant_on = [dwell.position for number, dwell in taken if stood[number, dwell.turn_on] > 1]
    positions = dict.fromkeys(map(position_name, leant_on))
    if not positions:
        return []
    return [
        f"nothing checks position{'s' if len(positions) > 1 else ''} {', '.join(positions)}: all that was counted "
        f"there is taken by what is solved, and a crumb under the cube would leave no residual; record more "
        f"positions, and do not switch the unit off between them"
    ]


def _said(lone: Sequence[tuple[Campaign, DwellRecord]], why: str, advice: str) -> list[str]:
    if not lone:
        return []
    positions = dict.fromkeys(position_name(dwell.position) for _, dwell in lone)
    leaning = sorted({name for each, dwell in lone for name in _leaning(each, dwell.position)})
    is_moved = any(dwell.name in (move.before, move.after) for each, dwell in lone for move in each.moves)
    moved = ", as do gyroscope scale factor and misalignment by the moves from and to it" if is_moved else ""
    return [
        f"alone with their face up: position{'s' if len(positions) > 1 else ''} {', '.join(positions)}; {why} "
        f"shows whether the cube stood clean there, and accelerometer misalignment {', '.join(leaning)} "
        f"leans on it{moved}; {advice}"
    ]


def _alone(
    campaigns: Sequence[Campaign], askew: Collection[tuple[int, str]] = ()
) -> list[tuple[Campaign, DwellRecord]]:
    """Return campaign and dwell of dwells alone with their face up, of those that are not ``askew``."""
    dwells = [
        (each, dwell)
        for number, each in enumerate(campaigns)
        for dwell in each.dwells
        if (number, dwell.name) not in askew
    ]
    stood = Counter(_cube_and_face(each, face_of(dwell.position)) for each, dwell in dwells)
    stood.update(_cube_and_face(each, rest.up) for each in campaigns for rest in each.rests if rest.up)
    return [one for one in dwells if stood[_cube_and_face(one[0], face_of(one[1].position))] == 1]


def _cube_and_face(campaign: Campaign, face: str) -> tuple[str, str]:
    return campaign.fixture.id or "", face


def _leaning(campaign: Campaign, position: int) -> list[str]:
    """Return the misalignments, sensor and axis as ``xy``, that a dwell's level sensors tell."""
    up = AXES[int(np.argmax(np.abs(campaign.fixture.C_sb @ face_normal(face_of(position)))))]
    return [sensor + up for sensor in AXES if sensor != up]
