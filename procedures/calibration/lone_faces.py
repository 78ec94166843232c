"""What a solution says of faces of the cube that stood once: no second dwell shows whether they stood clean.

A cube that leans in the only dwell of a face is to the level sensors half a misalignment and half a bias. Other
faces know the biases, but in dwells of some seconds not to the last arcseconds, and they do not tell which seat it
was. The sigma holds the seat's 1 sigma as it is stated, and no more.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from procedures.campaign.campaign import Campaign
from procedures.frames import AXES, face_normal, face_of, position_name


def lone_face_warnings(campaigns: Sequence[Campaign]) -> list[str]:
    """Say which positions were alone with their face up, and what leans on them; nothing if all faces stood twice.

    Campaigns with the same cube count together; those whose cube has no name are taken for one cube's.
    """
    lone = _alone(campaigns)
    if not lone:
        return []
    positions = dict.fromkeys(position_name(position) for _, position in lone)
    leaning = sorted({name for each in lone for name in _leaning(*each)})
    return [
        f"alone with their face up: position{'s' if len(positions) > 1 else ''} {', '.join(positions)}; no second "
        f"dwell shows whether the cube stood clean there, and accelerometer misalignment {', '.join(leaning)} "
        f"leans on it; record the other position of the face too"
    ]


def _alone(campaigns: Sequence[Campaign]) -> list[tuple[Campaign, int]]:
    """Return campaign and position of dwells with whose face up the same cube did not stand again."""
    dwells = [(each, dwell.position) for each in campaigns for dwell in each.dwells]
    stood = Counter(_cube_and_face(each, face_of(position)) for each, position in dwells)
    stood.update(_cube_and_face(each, rest.up) for each in campaigns for rest in each.rests if rest.up)
    return [one for one in dwells if stood[_cube_and_face(one[0], face_of(one[1]))] == 1]


def _cube_and_face(campaign: Campaign, face: str) -> tuple[str, str]:
    return campaign.fixture.id or "", face


def _leaning(campaign: Campaign, position: int) -> list[str]:
    """Return the misalignments, sensor and axis as ``xy``, that a dwell's level sensors tell."""
    up = AXES[int(np.argmax(np.abs(campaign.fixture.C_sb @ face_normal(face_of(position)))))]
    return [sensor + up for sensor in AXES if sensor != up]
