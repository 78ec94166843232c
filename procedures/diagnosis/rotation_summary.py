"""What turns show where they determine no calibration: one turn, a few of one axis, a gyroscope alone.

The axis of a turn stands still, so the Earth's rate along it is the same while it turns and while it rests: the
rests before and after take it off together with the bias,

    turned = integral of (output - output at rest) dt,    scale factor = turned / true angle

What a turn leaves open: a scale factor that differs by direction or rate, and the bias apart from the Earth's.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, TurnRecord
from procedures.campaign.observations import channel
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import AXES, rotation_vector
from procedures.free_positions.gyroscopes_from_moves import SegmentedSequence, segment
from procedures.positions import face_normal, face_of
from procedures.twelve_positions.manual_rotations import END_REST_S
from procedures.twelve_positions.transfer_rotation import move_rotations, padded_moves
from procedures.units import STANDARD_GRAVITY

AT_REST = 0.001  # of the fastest rate: faster moves
NOISE_SIGMAS = 6.0  # sigmas of a sample, by which one that moves stands off at the least
QUIET_SHARE = 0.7  # of the time before it is seen to move: a hand begins slowly
AS_STATED = 0.1  # of the angle stated: by the unit stated farther from it, it was another
FAR_MORE = 3.0  # times: another gyroscope whose output changes so much more stands nearer to the axis turned


@dataclass(frozen=True, slots=True)
class TurnSeen:
    """A turn as the gyroscope along its axis saw it, outputs as they come, each with 1 sigma.

    ``revolutions`` is signed by direction; ``at_rest`` [output/s, or output of rates] and ``scale`` [output/deg,
    or output/(deg/s)] are None where it does not rest at both ends, or samples are missing. ``turned_deg`` is by
    the unit stated, None where none is; ``is_as_stated``: that is about the angle that was stated.
    ``is_reversed``: about as many, the other way; ``other`` is the gyroscope that changed far more, if any did.
    """

    name: str
    axis: str
    sensor: int
    revolutions: float
    seconds: float
    is_count: bool
    at_rest: tuple[float, float] | None
    scale: tuple[float, float] | None
    turned_deg: tuple[float, float] | None
    is_as_stated: bool
    is_reversed: bool = False
    other: int | None = None


def turns_seen(campaigns: Sequence[Campaign]) -> list[TurnSeen]:
    """Return what each turn's own gyroscope saw of it; nothing of a turn whose gyroscope is not there."""
    return [seen for campaign in campaigns for turn in campaign.turns for seen in _seen(campaign, turn)]


def _seen(campaign: Campaign, turn: TurnRecord) -> Iterator[TurnSeen]:
    if turn.series.gyro is None:
        return
    period, counts = turn.series.period, isinstance(turn.series, CountSeries)
    up = campaign.fixture.C_sb @ face_normal(face_of(turn.start_position))
    sensor = int(np.argmax(np.abs(up)))
    rate = np.asarray(turn.series.gyro, dtype=np.float64)[:, sensor] / (period if counts else 1.0)
    if not np.ptp(rate):
        return
    revolutions = turn.revolutions * (1 if turn.direction == "+" else -1) * int(np.sign(up[sensor]))
    ends, missing = _rests(rate, period), len(turn.series.starts) > 1
    found = None if missing or ends is None else _integrated(rate, period, ends)
    other = _moved_far_more(np.asarray(turn.series.gyro, dtype=np.float64), sensor)
    scale, turned, is_as_stated, is_reversed = None, None, True, False
    nominal = campaign.nominal_scale.get("gyroscope")
    if found is not None:
        _, total, total_std = found
        closed = np.hypot(total_std / abs(total), campaign.sigma.closure / (2 * np.pi * turn.revolutions))
        scale = total / (360.0 * revolutions), float(abs(total / (360.0 * revolutions)) * closed)
        if nominal:
            turned = total / nominal, total_std / abs(nominal)
            share = turned[0] / (360.0 * revolutions)
            is_as_stated, is_reversed = abs(share - 1) < AS_STATED, abs(share + 1) < AS_STATED
    yield TurnSeen(
        turn.name, f"{turn.direction}{turn.axis}", sensor, revolutions, len(rate) * period, counts,
        None if found is None else found[0], scale if is_as_stated and other is None else None, turned,
        is_as_stated, is_reversed, other,
    )  # fmt: skip


def _moved_far_more(rates: FloatArray, sensor: int) -> int | None:
    """Return the gyroscope whose output changes far more than that of the axis stated, None where none does."""
    ranges = np.nan_to_num(np.ptp(rates, axis=0))
    most = int(np.argmax(ranges))
    return most if ranges[most] > FAR_MORE * ranges[sensor] else None


def _rests(rate: FloatArray, period: float) -> tuple[slice, slice] | None:
    """Return the rests before and after a turn; None where it does not rest at both ends."""
    first = max(round(END_REST_S / 2 / period), 2)
    fastest, ends = float(np.max(np.abs(rate - np.median(rate[:first])))), list[int]()
    for one in (rate, rate[::-1]):
        level, noise = float(np.median(one[:first])), float(np.std(np.diff(one[:first]))) / np.sqrt(2)
        moving = np.flatnonzero(np.abs(one - level) > max(AT_REST * fastest, NOISE_SIGMAS * noise))
        ends.append(int(moving[0]) if len(moving) else 0)
    if min(ends) * period < END_REST_S:
        return None
    before, after = (round(QUIET_SHARE * end) for end in ends)
    return slice(0, before), slice(len(rate) - after, len(rate))


def _integrated(
    rate: FloatArray, period: float, ends: tuple[slice, slice]
) -> tuple[tuple[float, float], float, float]:
    """Return the output at rest with 1 sigma, and what the turn adds to it, integrated, with 1 sigma."""
    before, after = (rate[end] for end in ends)
    noise = float(np.sqrt((np.var(before) + np.var(after)) / 2))
    both = np.array([before.mean(), after.mean()])
    std = float(np.hypot(noise / np.sqrt(len(before) + len(after)), np.ptp(both) / 2))
    at_rest = float(np.average(both, weights=[len(before), len(after)]))
    turning = rate[ends[0].stop : ends[1].start] - at_rest
    total_std = float(np.hypot(std * len(turning) * period, noise * np.sqrt(len(turning)) * period))
    return (at_rest, std), float(turning.sum()) * period, total_std


def left_open(turns: Sequence[TurnSeen]) -> list[str]:
    """Return what turns of these axes and directions do not show, in words."""
    several = {
        seen.sensor: {np.sign(each.revolutions) for each in turns if each.sensor == seen.sensor} for seen in turns
    }
    one_way = [AXES[sensor] for sensor, ways in several.items() if len(ways) == 1]
    right = [seen for seen in turns if seen.other is None]
    texts = sorted({_turned_otherwise(seen) for seen in turns if seen.other is not None or seen.is_reversed})
    if any(not seen.is_as_stated and not seen.is_reversed for seen in right):
        texts.append(
            "a scale factor: the stated angle contradicts the gyroscope (state turn:+z:ANGLEdeg, or --reference)"
        )
    if any(seen.is_as_stated and seen.scale is None for seen in right):
        texts.append("the bias separately from the rotation (rest for 2 s before and after)")
    if one_way:
        texts.append(f"a scale factor of {', '.join(one_way)} that differs by direction (turn the other way)")
    texts.append("the bias without the Earth's rate")
    return texts


def _turned_otherwise(seen: TurnSeen) -> str:
    """Return how a rotation was another than was stated, in words."""
    stated, axis = AXES[seen.sensor], seen.axis[1:]
    if seen.other is not None:
        most = AXES[seen.other]
        return f"a scale factor of {stated}: gyroscope {most} changed more (state turn:+{most} or turn:-{most})"
    return (
        f"a scale factor of {stated}: it turned the other way (state "
        f"turn:{'-' if seen.axis[0] == '+' else '+'}{axis})"
    )


def pooled(turns: Sequence[TurnSeen]) -> dict[int, tuple[float, float]]:
    """Return by sensor the mean scale factor of several turns; its 1 sigma holds by how much they differ."""
    found = dict[int, tuple[float, float]]()
    for sensor in sorted({seen.sensor for seen in turns}):
        stated = [seen.scale for seen in turns if seen.sensor == sensor and seen.scale is not None]
        if len(stated) > 1:
            value, std = np.array(stated).T
            weight = 1 / std**2
            mean = float(np.sum(weight * value) / weight.sum())
            squares = float(np.sum(weight * (value - mean) ** 2)) / (len(stated) - 1)
            found[sensor] = mean, float(np.sqrt(max(squares, 1.0) / weight.sum()))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class RestSeen:
    """A rest: how long [s], how much longer than gravity the specific force is [g], None without a unit."""

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
    """Return the moves of all sequences of gyroscopes whose unit is stated."""
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
