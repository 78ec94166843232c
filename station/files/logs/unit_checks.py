"""Units that were given or guessed, held against what is physically possible at rest.

Gravity is 9.8 m/s2 whatever the unit, and no gyroscope shows more than 20 deg/s at rest. Where another unit, range
or kind of output would explain what was found it is named and the log refused; what nothing explains, as of a
damaged sensor, gives a note and is used. Without a unit (``raw``) nothing is claimed and nothing refused.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_times import own_period
from procedures.errors import ErrorCode
from procedures.rest_plausibility import (
    MATCH_TOLERANCE,
    MAX_RAW_RATE,
    MOST_NAMED,
    RANGES,
    Assumption,
    Contradiction,
    contradiction,
    explanations,
    signed,
    unsigned_bits,
    width,
)
from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY
from station.errors import DataRefused
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, RAW, outputs_per_unit

LSB_PER_G = (16384, 8192, 4096, 2048, 1024, 512, 256, 128)  # of common accelerometers, by their range
LSB_PER_DEG_S = (131, 65.5, 32.8, 16.4, 114.3, 57.1, 28.6, 14.3)  # of common gyroscopes, by their range
INTERVALS_S = (1e-3, 2e-3, 2.5e-3, 4e-3, 5e-3, 8e-3, 0.01, 0.02, 0.025, 0.04, 0.05, 0.1, 0.2, 0.25, 0.5)
OWN_TOLERANCE = 0.005  # relative, of the sample period against an interval that its device was set to
INTERVAL_TOLERANCE = 0.03  # relative: increments are of an interval that a logger can be set to
GRAVITY_REMOVED = 0.05 * STANDARD_GRAVITY  # m/s2 at rest: below it gravity was taken out


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """Samples of a log at ``t`` (n,) [s], None without time; outputs (n, 3) of each triad, units.

    Keys are ``gyro`` and ``accel``; a channel that is not there has no name. ``stated`` are units from options.
    """

    file: Path
    t: FloatArray | None
    outputs: Mapping[str, FloatArray | None]
    names: Mapping[str, Sequence[str | None]]
    units: Mapping[str, str | None]
    stated: Mapping[str, str | None]

    def is_there(self, triad: str) -> BoolArray:
        """Return a boolean (3,) that says which axes are measured: named, and not one number throughout."""
        values = self.outputs[triad]
        if values is None:
            return np.zeros(3, dtype=np.bool_)
        named = np.array([name is not None for name in self.names[triad]])
        found: BoolArray = named & (np.ptp(values, axis=0) > 0)
        return found


def check_units(log: Readings) -> list[str]:
    """Return what is reported of a log whose units are possible.

    Raises
    ------
    DataRefused
        With code E-UNIT, if signed integers were printed as unsigned, or a unit contradicts gravity or the rest
        and other units would not: they are named.
    """
    sample_rate = 1 / own_period(log.t) if log.t is not None and len(log.t) > 1 else None
    force = None if sample_rate is None else _of_force(log, sample_rate)
    notes = _unsigned(log, force)
    rate = None if sample_rate is None else _of_rate(log, sample_rate)
    return notes + [each.reported_of(log.file) for each in (force, rate) if each is not None]


@dataclass(frozen=True, slots=True)
class _Impossible:
    """What was found and expected of a ``triad``, and which other assumptions would explain it."""

    triad: str
    found: str
    expected: str
    explained: Sequence[str]
    unexplained: str

    def reported_of(self, file: Path) -> str:
        """Return it in a sentence; raise `DataRefused` where something explains it."""
        if not self.explained:
            return f"{self.found}, expected {self.expected}: {self.unexplained}"
        others = ", or ".join(dict.fromkeys(self.explained[:MOST_NAMED]))
        remedy = f"the data are consistent with {others}; or continue with --unit-{self.triad} raw"
        raise DataRefused(file, None, self.found, self.expected, remedy, ErrorCode.UNIT)


def _unsigned(log: Readings, force: "_Impossible | None") -> list[str]:
    notes = list[str]()
    for triad, values in log.outputs.items():
        if values is None:
            continue
        bits = {i: found for i in range(3) if (found := unsigned_bits(values[:, i])) is not None}
        if not bits:
            continue
        of = ", ".join(str(log.names[triad][i]) for i in bits)
        most = max(bits.values())
        jumps = f"{of} jump{'s' if len(bits) == 1 else ''} between about 0 and {2**most - 1}"
        if log.stated.get(triad) == RAW:
            notes.append(f"{jumps}: two's complement of {most} bits was not applied")
            continue
        what = f"{jumps}: signed {most}-bit integers printed as unsigned" + (f"; {force.found}" if force else "")
        remedy = f"subtract {2**most} from values of {2 ** (most - 1)} up, or continue with --unit-{triad} raw"
        raise DataRefused(log.file, None, what, "signed numbers near zero", remedy, ErrorCode.UNIT)
    return notes


def _of_force(log: Readings, sample_rate: float) -> _Impossible | None:
    unit, values = log.units.get("accel"), log.outputs["accel"]
    per_g = outputs_per_unit(unit, ACCEL_UNITS) if unit else None
    if values is None or unit is None or not per_g:
        return None
    axes = log.is_there("accel")
    force = np.where(axes, values, 0.0) * (STANDARD_GRAVITY / per_g)
    found = contradiction(force, None, sample_rate, axes=axes)
    if found is None or found.rest is None:
        return None
    what = f"a specific force of {found.found:.3g} m/s2 at rest, accelerometers in {unit}"
    others = _units(unit, per_g, ACCEL_UNITS, LSB_PER_G, "g", "accel")
    others += _increments(found, sample_rate, per_g, log)
    text = [each.name for each in explanations(found, others)]
    if (bits := _twos_complement(log, axes, per_g)) is not None:
        text.insert(0, f"signed {bits}-bit integers printed as unsigned")
    no_gravity = found.found < GRAVITY_REMOVED and bool(axes.all())
    unexplained = "gravity was removed from them" if no_gravity else "no other unit explains it"
    return _Impossible("accel", what, "9.8 m/s2 within 20 %", text, unexplained)


def _of_rate(log: Readings, sample_rate: float) -> _Impossible | None:
    units = {triad: log.units.get(triad) for triad in ("gyro", "accel")}
    gyro, accel = log.outputs["gyro"], log.outputs["accel"]
    per_deg_s = outputs_per_unit(units["gyro"], GYRO_UNITS) if units["gyro"] else None
    per_g = outputs_per_unit(units["accel"], ACCEL_UNITS) if units["accel"] else None
    if gyro is None or accel is None or not per_deg_s or not log.is_there("accel").all():
        return None
    if not per_g:  # the length is gravity's, where nobody stated the unit
        per_g = float(np.median(np.linalg.norm(accel, axis=1))) or 1.0
    rate = gyro * (RAD_PER_DEG / per_deg_s)
    found = contradiction(accel * (STANDARD_GRAVITY / per_g), rate, sample_rate, max_rate=MAX_RAW_RATE)
    if found is None or found.quantity != "angular rate":
        return None
    unit = units["gyro"] or RAW
    what = f"an angular rate of {found.found / RAD_PER_DEG:.3g} deg/s at rest, gyroscopes in {unit}"
    others = _units(unit, per_deg_s, GYRO_UNITS, LSB_PER_DEG_S, "(deg/s)", "gyro")
    text = [each.name for each in explanations(found, others, max_rate=MAX_RAW_RATE)]
    return _Impossible("gyro", what, "at most 20 deg/s", text, "no other unit explains it")


def _units(
    unit: str, per: float, known: Mapping[str, float], codes: Sequence[float], of: str, triad: str
) -> list[Assumption]:
    """Return other units that the outputs may be in, by the option that says them."""
    option = f"--unit-{triad}"
    others = [Assumption(f"{option} {name}", per / other) for name, other in known.items() if name != unit]
    if unit in known:
        return others + [Assumption(f"{option} {code:g}/{of}", per / code) for code in codes]
    of_ranges = [Assumption(f"{option} {per / factor:g}/{of} (another range)", factor) for factor in RANGES]
    return of_ranges + others


def _increments(found: Contradiction, sample_rate: float, per_g: float, log: Readings) -> list[Assumption]:
    """Return the interval whose velocity increments the outputs are: of a sample, or shorter where rows lack.

    Gyroscopes whose unit was stated, not named by their columns, are increments of angle alongside them.
    """
    own = next((known for known in INTERVALS_S if abs(known * sample_rate - 1) < OWN_TOLERANCE), 1 / sample_rate)
    gyro = log.stated.get("gyro")
    per_deg_s = outputs_per_unit(gyro, GYRO_UNITS) if gyro else None
    for interval in (own, *INTERVALS_S):
        is_possible = interval == own or interval < 1.01 / sample_rate
        if is_possible and abs(found.found / interval / STANDARD_GRAVITY - 1) < INTERVAL_TOLERANCE:
            options = f"--unit-accel {per_g * interval:.6g}/g"
            if per_deg_s:
                options += f" --unit-gyro {quote(f'{per_deg_s * interval:.6g}/(deg/s)')}"
            what = "velocity and angle" if per_deg_s else "velocity"
            return [Assumption(f"increments of {what} in {interval:.4g} s ({options})", 1 / interval)]
    return []


def _twos_complement(log: Readings, axes: BoolArray, per_g: float) -> int | None:
    """Return the width of integers whose sign, if applied, makes the length at rest 1 g; None where none does."""
    values = log.outputs["accel"]
    assert values is not None
    if values.min() < 0 or not (values == np.rint(values)).all() or not axes.all():
        return None
    if (bits := width(float(values.max()))) is None:
        return None
    usual = float(np.median(np.linalg.norm(signed(values, bits), axis=1))) / per_g
    return bits if abs(usual - 1) < MATCH_TOLERANCE else None
