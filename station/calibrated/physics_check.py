"""Whether what a calibration makes of a recording is physically possible, and what would make it right."""

from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_times import own_period
from procedures.errors import ErrorCode
from procedures.frames import AXES
from procedures.rest_plausibility import (
    ALL_AXES,
    GRAVITY_TOLERANCE,
    MAX_RAW_RATE,
    MOST_NAMED,
    RANGES,
    Assumption,
    Contradiction,
    RestSurvey,
    explanations,
    unsigned_bits,
)
from procedures.units import RAD_PER_DEG, S_PER_H, S_PER_MIN, STANDARD_GRAVITY
from station.errors import DataRefused

FIRST_SAMPLES = 4096  # in which two's complement that was not applied shows, and the pace of rates
CHANNELS = tuple(f"{triad} {axis}" for triad in ("gyroscope", "accelerometer") for axis in AXES)
_TIME = "the time stamps are in a unit {}"
_TIMES = {
    1e3: "1000 times smaller (ms for s, us for ms)", 1e6: "1e6 times smaller (us for s)",
    1e9: "1e9 times smaller (ns for s)", 1e4: "10,000 times smaller (ticks of 0.1 ms for s)",
    S_PER_MIN: "60 times smaller (s for min)", S_PER_H: "3600 times smaller (s for h)",
    1e-3: "1000 times larger (s for ms, ms for us)", 1e-6: "1e6 times larger (s for us)",
    1e-9: "1e9 times larger (s for ns)", 1 / S_PER_MIN: "60 times larger (min for s)",
    1 / S_PER_H: "3600 times larger (h for s)",
}  # fmt: skip


@dataclass(slots=True, eq=False)
class PhysicsCheck:
    """Takes calibrated samples block by block and says at the end what of them is impossible.

    ``period`` [s] is that of a sample, None of rates: then it is read from the times. ``offset`` (3,) [m/s2] is
    what the calibration takes off, in the frame of the output. ``where`` and ``go_on`` are for messages.
    """

    period: float | None
    offset: FloatArray
    is_of_counts: bool
    force: bool = False
    where: str = "counts"
    go_on: str = "continue with force=True"
    axes: BoolArray = field(default_factory=lambda: ALL_AXES)
    _survey: RestSurvey | None = None
    _first: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = field(default_factory=list)
    _count: int = 0
    _unsigned: str = ""
    _has_outputs: bool = False  # of accelerometers: zeros alone are those of a triad that is not there

    def take(self, values: FloatArray, t: FloatArray, force: FloatArray, rate: FloatArray) -> None:
        """Take further samples.

        Parameters
        ----------
        values : (n, 6) float64
            Outputs as they came, of gyroscopes and accelerometers.
        t : (n,) float64, s
            Their time.
        force : (n, 3) float64, m/s2
            Their specific force.
        rate : (n, 3) float64, rad/s
            Their angular rate.
        """
        self._has_outputs = self._has_outputs or bool(values[:, 3:].any())
        if self._survey is not None:
            self._survey.take(force, rate)
            return
        self._first.append((values, t, force, rate))
        self._count += len(t)
        if self._count >= FIRST_SAMPLES:
            self._begin()

    def refusal(self) -> DataRefused | None:
        """Return what of all samples contradicts physics as an error that is not raised; None of nothing."""
        if self._survey is None and self._count:
            self._begin()
        if self._unsigned:
            return DataRefused(
                self.where, None, self._unsigned, "signed numbers, as near zero",
                f"apply two's complement to the columns, or {self.go_on}", ErrorCode.UNIT,
            )  # fmt: skip
        if self._survey is None or not self._has_outputs:
            return None
        self._survey.finish()
        found = self._survey.verdict()
        if found is None or (found.rest is None and not self._explained(found, self._survey.period)):
            return None  # what never rests and no wrong unit explains may be a motion
        return self._refusal(found, self._survey.period)

    def _begin(self) -> None:
        values, t, force, rate = (np.concatenate([each[i] for each in self._first]) for i in range(4))
        self._first = []
        for i, name in enumerate(CHANNELS):
            if not self._unsigned and (bits := unsigned_bits(values[:, i])) is not None:
                jumps = f"{name} jumps between about 0 and {2**bits - 1}"
                self._unsigned = f"{jumps}: signed {bits}-bit integers printed as unsigned"
        if self.period is None and len(t) < 2:
            return
        self._survey = RestSurvey(own_period(t) if self.period is None else self.period, self.axes)
        self._survey.take(force, rate)

    def _refusal(self, found: Contradiction, period: float) -> DataRefused:
        rest, named = found.rest, self._explained(found, period)
        after = "" if rest is None else f", {rest.first * period:.3g} s after the first sample"
        if found.quantity == "specific force":
            what = f"a specific force of {found.found:.3g} m/s2 {'in the middle' if rest is None else 'at rest'}"
            expected = f"{STANDARD_GRAVITY:.1f} m/s2 within {100 * GRAVITY_TOLERANCE:.0f} %"
            code = ErrorCode.GRAVITY
        else:
            what = f"an angular rate of {found.found / RAD_PER_DEG:.3g} deg/s at rest"
            expected = f"below {found.allowed / RAD_PER_DEG:.2g} deg/s, as gravity's direction does not change"
            code = ErrorCode.RATE_AT_REST
            if found.found < MAX_RAW_RATE:
                named.append("the bias has changed since the calibration")
        either = ", or if ".join(named[:MOST_NAMED])
        would = f"it would be correct if {either}" if named else "no single wrong unit or range explains it"
        return DataRefused(
            self.where, None, f"{what}{after}", expected, f"{would}; correct it, or {self.go_on}", code
        )

    def _explained(self, found: Contradiction, period: float) -> list[str]:
        return [each.name for each in explanations(found, self._assumptions(found, period), self.offset)]

    def _assumptions(self, found: Contradiction, period: float) -> list[Assumption]:
        ranges = [
            Assumption(f"the full-scale range is {factor:g} times that of the calibration", factor)
            for factor in RANGES
        ]
        if found.quantity == "angular rate":  # gravity agrees, so that the time is right
            small = [each for each in ranges if each.factor < 1]
            if self.is_of_counts:
                return [Assumption("the gyroscopes' outputs are per second, not per sample", period), *small]
            return [Assumption("angular rates are in deg/s and the calibration is in rad/s", RAD_PER_DEG), *small]
        if self.is_of_counts:
            times = [Assumption(_TIME.format(words), factor) for factor, words in _TIMES.items()]
            times = [Assumption("the outputs are per second, not per sample", period), *times]
            return times if found.rest is None else [*times, *ranges]
        increments = Assumption("the outputs are increments of each sample, not rates", 1 / period)
        if found.rest is None:
            return [increments]
        return [
            increments,
            Assumption("the outputs are in g and the calibration is in m/s2", STANDARD_GRAVITY),
            Assumption("the outputs are in m/s2 and the calibration is in g", 1 / STANDARD_GRAVITY),
            Assumption("the outputs are in mg and the calibration is in g", 1e-3),
            Assumption("the outputs are in g and the calibration is in mg", 1e3),
            *ranges,
        ]
