"""What a recording that moves and rests shows by the units told, where it determines no calibration.

Of every rest how long the specific force is against gravity, of every move between two rests by how much the
gyroscopes say that it turned, and whether gravity, carried along by them, comes out where the accelerometers have
it afterwards. The gyroscopes' bias is that of the rests on either side; the Earth's rate is in it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import channel
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import rotation_vector
from procedures.free_positions.gyroscopes_from_moves import SegmentedSequence, segment
from procedures.twelve_positions.transfer_rotation import move_rotations, padded_moves
from procedures.units import STANDARD_GRAVITY


@dataclass(frozen=True, slots=True, eq=False)
class RestSeen:
    """A rest: how long [s], how much longer than gravity the specific force is [g], None where no unit is told."""

    name: str
    seconds: float
    excess: float | None


@dataclass(frozen=True, slots=True, eq=False)
class MoveSeen:
    """A move from a rest to the next: how long [s], and what turned in it.

    ``turned`` (3,) [deg] is the integral of each gyroscope, ``angle`` [deg] the rotation that all three make, at
    most 180. ``tilted`` [deg] is the angle between the specific forces before and after, ``apart`` [deg] that
    between the one after and the one before carried along by the gyroscopes; None without accelerometers.
    """

    name: str
    seconds: float
    turned: FloatArray
    angle: float
    tilted: float | None
    apart: float | None


def rests_seen(campaigns: Sequence[Campaign]) -> list[RestSeen]:
    """Return the rests of all sequences."""
    found = list[RestSeen]()
    for each in segment(campaigns):
        campaign = campaigns[each.campaign]
        per_g = campaign.nominal_scale.get("accelerometer")
        gravity = campaign.site.gravity / STANDARD_GRAVITY
        for rest in each.rests:
            force = _mean(rest.series, "accelerometer", slice(None))
            excess = None if force is None or per_g is None else float(np.linalg.norm(force)) / per_g - gravity
            found.append(RestSeen(rest.name, len(rest.series) * rest.series.period, excess))
    return found


def moves_seen(campaigns: Sequence[Campaign]) -> list[MoveSeen]:
    """Return the moves of all sequences of gyroscopes whose unit is told."""
    return [
        move
        for each in segment(campaigns)
        if (per_deg_s := campaigns[each.campaign].nominal_scale.get("gyroscope")) is not None
        and each.record.series.gyro is not None
        for move in _moves(each, per_deg_s)
    ]


def _moves(sequence: SegmentedSequence, per_deg_s: float) -> Iterator[MoveSeen]:
    series, stretches = sequence.record.series, sequence.stretches
    for i, samples in sequence.moves():
        around = [_mean(series, "gyroscope", stretches[j]) for j in (i, i + 1)]
        rate = _rates(series, "gyroscope", samples)
        if around[0] is None or around[1] is None or rate is None or not len(rate):
            continue
        b = (around[0] + around[1]) / 2
        C = move_rotations(padded_moves([rate], [series.period]), per_deg_s * np.eye(3), b)[0]
        force = [_mean(series, "accelerometer", stretches[j]) for j in (i, i + 1)]
        tilted = apart = None
        if force[0] is not None and force[1] is not None:
            tilted, apart = _angle(force[0], force[1]), _angle(C @ force[0], force[1])
        turned = (rate - b).sum(axis=0) * series.period / per_deg_s
        angle = float(np.degrees(np.linalg.norm(rotation_vector(C[None])[0])))
        name = f"{sequence.record.name} {series.t[samples.start]:.1f} s"
        yield MoveSeen(name, len(rate) * series.period, turned, angle, tilted, apart)


def _rates(series: Series, triad: str, rows: slice) -> FloatArray | None:
    samples = channel(series, triad)
    if samples is None:
        return None
    values = np.asarray(samples[rows], dtype=np.float64)
    return values / series.period if isinstance(series, CountSeries) else values


def _mean(series: Series, triad: str, rows: slice) -> FloatArray | None:
    rates = _rates(series, triad, rows)
    return None if rates is None or not len(rates) else rates.mean(axis=0)


def _angle(a: FloatArray, b: FloatArray) -> float:
    """Return the angle [deg] between two vectors (3,) of one unit."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
