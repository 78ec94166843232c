"""Manual rotations, + and - about each vertical axis: the gyroscopes' scale factor and misalignment.

A closed turn of R revolutions about the slab's normal integrates to ``2 pi R`` along the face's normal, plus what
the Earth added, whose horizontal part is integrated over the heading that the gyroscope measured. Yao 2018 names
the method ("rate method") without an equation; with K = diag(k) E, b = k D:

    total = K (theta n_b + C_b M w_n) + b T,   M = integral of Rz(-psi(t)) dt,   theta = +-2 pi R + closure
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TurnTotal, channel
from procedures.errors import TurnsDisagree
from procedures.frames import AXES
from procedures.positions import face_normal, face_of

MAX_SCALE_DISAGREEMENT = 0.1  # of the scale factor: far above any bias, far below a missing revolution
END_REST_S = 2.0  # of rest wanted at each end
MAX_REST_RATE_DEG_S = 0.5  # deg/s
OPEN_CLOSURE_STD_RAD = float(np.radians(0.1))  # 1 sigma of a turn that was not at rest at both ends, at the least


@dataclass(frozen=True, slots=True, eq=False)
class RotationGeometry:
    """A turn's angle about the slab's normal [rad], closure sigma [rad], and M (3, 3) [s]; ``open_ends`` warns."""

    angle: float
    closure_std: float
    motion: FloatArray
    open_ends: bool


def nominal_angle(turn: TurnTotal) -> float:
    """Return the angle [rad] turned about the slab's normal, counter-clockwise seen from above."""
    record = turn.record
    up = face_normal(face_of(record.start_position))[AXES.index(record.axis)]
    return float((1 if record.direction == "+" else -1) * up * 2 * np.pi * record.revolutions)


def heading_history(
    turn: TurnTotal, C_sb: FloatArray, K: FloatArray, b: FloatArray, vertical: float
) -> FloatArray:
    """Return (n,) the angle [rad] turned up to the middle of each sample, scaled to the nominal whole.

    Parameters
    ----------
    turn : of n samples
    C_sb : (3, 3), takes the cube's axes to the IMU's
    K, b : (3, 3) [output/deg], (3,) [output/s]
    vertical : deg/s, the Earth rate's vertical part
    """
    samples = np.asarray(channel(turn.record.series, "gyroscope"), dtype=float)
    rate = samples / turn.record.series.period if turn.counts else samples
    up = C_sb @ face_normal(face_of(turn.record.start_position))
    angle = np.cumsum((rate - b) @ np.linalg.solve(K.T, up) - vertical)
    half = np.diff(angle, prepend=0.0) / 2
    scaled: FloatArray = (angle - half) * nominal_angle(turn) / angle[-1]
    return scaled


def geometry(turn: TurnTotal, heading: FloatArray, closure_std: float) -> RotationGeometry:
    """Integrate the rotation over the ``heading`` (n,) [rad] turned and look whether the ends are at rest."""
    period = turn.record.series.period
    c, s = np.cos(heading).sum() * period, np.sin(heading).sum() * period
    motion = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, len(heading) * period]])
    n = max(round(END_REST_S / period), 1)
    moved = max(np.ptp(heading[:n]), np.ptp(heading[-n:]))
    open_ends = len(heading) < 2 * n or bool(moved > np.radians(MAX_REST_RATE_DEG_S) * END_REST_S)
    wide = max(10 * closure_std, OPEN_CLOSURE_STD_RAD)
    return RotationGeometry(nominal_angle(turn), wide if open_ends else closure_std, motion, open_ends)


def is_broken(turn: TurnTotal, heading: FloatArray) -> bool:
    """Say whether samples were lost while ``heading`` (n,) [rad] changed: the angle in the gap is unknown."""
    gaps = turn.record.series.starts[1:]
    n = max(round(0.1 / turn.record.series.period), 1)
    return any(
        np.ptp(heading[max(g - n, 0) : g + n])
        > np.radians(MAX_REST_RATE_DEG_S) * 2 * n * turn.record.series.period
        for g in gaps
    )


def refuse_disagreeing(campaigns: Sequence[Campaign], turns: Sequence[TurnTotal]) -> None:
    """Raise `TurnsDisagree` where turns about one axis imply scale factors `MAX_SCALE_DISAGREEMENT` apart."""
    per_turn: dict[int, list[tuple[str, float]]] = {}
    for turn in turns:
        up = campaigns[turn.campaign].fixture.C_sb @ face_normal(face_of(turn.record.start_position))
        sensor = int(np.argmax(np.abs(up)))
        per = float(turn.total[sensor] / up[sensor] / (nominal_angle(turn) / (2 * np.pi)))
        per_turn.setdefault(sensor, []).append((turn.record.name, per))
    for found in per_turn.values():
        first, other = min(found, key=lambda each: each[1]), max(found, key=lambda each: each[1])
        if other[1] - first[1] > MAX_SCALE_DISAGREEMENT * max(abs(other[1]), abs(first[1])):
            raise TurnsDisagree(*first, *other)
