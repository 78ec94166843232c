"""Hysteresis of a bias between warming and cooling: ``h d``, d = 1 while it warms, -1 while it cools.

What mounting, adhesive and winding keep of the way they came. Either the direction turns at once where temperature
has come back by half a kelvin, from the turning point on; or with a play, whose half width w is fitted: ``d = (T -
P) / w``, where P follows T as soon as T is farther away than w (Krasnosel'skii and Pokrovskii 1989), so that d
goes from one branch to the other in proportion while temperature comes back by 2 w. Of steady ramps it is the
temperature's rate. Plausible: 100 ug and 0.5 deg/h, half of what opens between the two branches.
"""

from dataclasses import replace

from procedures.arrays import FloatArray
from procedures.effects.effect import PLAY, Columns, Effect, Excitation, per_axis
from procedures.effects.temperature_history import direction_or_play, ranged_k
from procedures.effects.time_constant import with_nonlinear
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S

ACCEL_RANGE, GYRO_RANGE = 1e-4, 0.5
WITH_PLAY = "with a play"
SMALLEST_K = 0.3  # half width of a play that a search begins with: smaller ones turn at once
LARGEST = 0.5  # of the range of temperature: a wider play is a coefficient of temperature
RATIO = 1.7  # between neighbours
RANGE_K = (0.05, 50.0)  # within which it is fitted


def accelerometer_at(seen: Excitation, way: Columns) -> Columns:
    """Return d of a way [g per g], and a column for the play's half width where it has one."""
    return _way(way, ACCEL_RANGE, replace(way, accel=per_axis(_branch(seen, way))))


def gyroscope_at(seen: Excitation, way: Columns) -> Columns:
    """Return d of a way [deg/s per deg/h], and a column for the play's half width where it has one."""
    return _way(way, GYRO_RANGE, replace(way, gyro=per_axis(_branch(seen, way) / DEG_H_PER_DEG_S)))


def _branch(seen: Excitation, way: Columns) -> FloatArray:
    return direction_or_play(seen, way.nonlinear.get(PLAY, 0.0) if way.shape == WITH_PLAY else None)


def _way(way: Columns, most: float, found: Columns) -> Columns:
    nonlinear = way.nonlinear if way.shape == WITH_PLAY else {}
    plausible = (most,) * len(AXES)
    return with_nonlinear(replace(found, coefficients=tuple(AXES), nonlinear=nonlinear), plausible)


def first_ways(seen: Excitation) -> list[Columns]:
    """Return the direction alone, and half widths of a play that a search begins with."""
    ways, width = [Columns(())], SMALLEST_K
    while width <= LARGEST * ranged_k(seen):
        ways.append(Columns((), shape=WITH_PLAY, nonlinear={PLAY: width}))
        width *= RATIO
    return ways


ACCELEROMETER = Effect(
    name="accelerometer.temperature_hysteresis",
    unit="g",
    physics="h d, d = 1 while it warms, -1 while it cools; with a backlash d = (T - P) / w, abs(T - P) <= w",
    source="IEEE Std 1293, hysteresis of bias over temperature; Krasnosel'skii and Pokrovskii 1989, play",
    plausible=ACCEL_RANGE,
    columns=lambda seen: [accelerometer_at(seen, way) for way in first_ways(seen)],
    separate_by="a heating run up and down with ramps of different steepness and long plateaus",
    at=accelerometer_at,
    ranges={PLAY: RANGE_K},
    driver="temperature",
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.temperature_hysteresis",
    unit="deg/h",
    source="IEEE Std 952, hysteresis of bias over temperature; Krasnosel'skii and Pokrovskii 1989, play",
    plausible=GYRO_RANGE,
    columns=lambda seen: [gyroscope_at(seen, way) for way in first_ways(seen)],
    at=gyroscope_at,
)
