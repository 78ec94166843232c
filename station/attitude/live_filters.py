"""One attitude filter or two on the same samples: the first is shown, with the readings of both.

The joint (Kalman) filter always runs: it says whether the unit rests, and where north is.

The complementary filters of You and Lee run tick by tick on the Kalman filter's samples. The result follows from
the samples and not from how they were cut into ticks: a replay gives the same to the last bit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import MAX_FILTERED_TURN_S
from procedures.attitude.attitude_log import AttitudeLog, down_of, inclination
from procedures.attitude.complementary_filter import STEEP_PITCH, ComplementaryFilter
from procedures.attitude.complementary_gains import PAPER_GAINS, ComplementaryGains
from procedures.attitude.filter_choice import FORM_DESCRIPTIONS, FORMS, JOINT
from procedures.attitude.sensor_noise import gate_of, gyro_noise
from procedures.units import DEG_H_PER_RAD_S, STANDARD_GRAVITY
from station.attitude.live_kalman_filter import (
    ALIGN_S,
    NO_AID,
    AidValues,
    AttitudeEstimator,
    aided_at_end,
    compile_filter,
    joined,
)
from station.attitude.live_readings import AttitudeReading, FilterReading, SettlesAt
from station.calibrated.filter_settings import force_bias_std, gyro_bias_std
from station.calibrated.rates_and_forces import RatesAndForces


class ComplementaryFilterTrack:
    """One unit's attitude by one of `procedures.attitude.filter_choice.FORMS`.

    ``force_std`` [m/s2] and ``gyro_std`` [rad/s] are 1 sigma of the sensors' biases, nan where they are not known.
    """

    def __init__(
        self, name: str, aid: str, gains: ComplementaryGains = PAPER_GAINS, gravity: float = STANDARD_GRAVITY,
        force_std: float = np.nan, gyro_std: float = np.nan,
    ) -> None:  # fmt: skip
        self._name, self._form, self._gains, self._gravity = name, FORMS[name][aid], gains, gravity
        self._stds = force_std, gyro_std
        self._first: list[AttitudeLog] = []  # seconds to learn the noise from
        self._mixer: ComplementaryFilter | None = None
        self._last, self._shift, self._turning_s = np.nan, 0.0, 0.0

    def reset(self) -> None:
        """Take the next tick's time as one of another beginning: the attitude continues from where it was."""
        self._first.clear()
        self._shift = 0.0 if self._mixer is None else np.nan

    def take(self, t: FloatArray, inputs: RatesAndForces, aiding: AidValues = NO_AID) -> FilterReading | None:
        """Take ends ``t`` (n,) [s] and inputs of a tick; None while aligning. The aid is of the last sample."""
        if np.isnan(self._shift):
            self._shift = self._last + float(t[1] - t[0] if len(t) > 1 else 0.0) - float(t[0])
        log = aided_at_end(t + self._shift, inputs, self._speed(aiding), aiding.velocity, aiding.heading)
        before = self._last
        self._last = float(log.t[-1])
        if self._mixer is None:
            self._first.append(log)
            if self._last - self._first[0].t[0] < ALIGN_S:
                return None
            log = joined(self._first)
            before = float(log.t[0])
            self._first.clear()
            log.f_b[0] = log.f_b.mean(axis=0)  # of one sample it is the counter's step more than anything
            self._mixer = ComplementaryFilter(self._gains, self._form, gate_of(gyro_noise(log)), self._gravity)
        self._mixer.run(log)
        self._turning_s = self._turning_s + self._last - before if self._mixer.is_turning else 0.0
        return self._found(self._mixer)

    def _found(self, mixer: ComplementaryFilter) -> FilterReading:
        roll, pitch = mixer.attitude
        x, y, z = (mixer.gyro_bias * DEG_H_PER_RAD_S).tolist()
        d0, d1, d2 = down_of(np.array(roll), np.array(pitch)).tolist()
        text = mixer.final_bias(*self._stds)
        settles = None if text is None else SettlesAt(
            *np.degrees([text.roll, text.pitch, text.roll_std, text.pitch_std]).tolist()
        )  # fmt: skip
        return FilterReading(
            self._name, FORM_DESCRIPTIONS[self._form], float(np.degrees(roll)), float(np.degrees(pitch)),
            (d0, d1, d2), (x, y, z), settles, self._note(mixer),
        )  # fmt: skip

    def _note(self, mixer: ComplementaryFilter) -> str:
        if mixer.is_printed and abs(mixer.attitude[1]) > STEEP_PITCH:
            return f"{self._name}: pitch beyond 80 deg, its Euler angles fail there; use joint or mixer"
        if self._form == "paper-filter" and self._turning_s > MAX_FILTERED_TURN_S:
            return f"{self._name}: rotating for more than {MAX_FILTERED_TURN_S:.0f} s, it diverges then; use joint"
        return ""

    def _speed(self, aiding: AidValues) -> float:
        """Return the speed along body x [m/s]: the airspeed, else what a GNSS velocity says of it."""
        north, east, down = aiding.velocity
        if np.isfinite(aiding.airspeed) or np.isnan(north):
            return aiding.airspeed
        ahead = np.hypot(north, east)
        if np.isfinite(aiding.heading):
            ahead = north * np.cos(aiding.heading) + east * np.sin(aiding.heading)
        pitch = 0.0 if self._mixer is None else self._mixer.attitude[1]
        return float(ahead * np.cos(pitch) - down * np.sin(pitch))


class LiveFilters:
    """The filters asked for, alongside a joint filter; ``calibration`` says the sigma of the sensors' biases."""

    def __init__(
        self, filters: Sequence[str], aid: str, joint: AttitudeEstimator, calibration: Mapping[str, Any] | None,
        gravity: float, gains: ComplementaryGains | None = None,
    ) -> None:  # fmt: skip
        self._filters, self._aid, self._joint = tuple(filters), aid, joint
        stds = (np.nan, np.nan)
        if calibration is not None:
            stds = force_bias_std(calibration), gyro_bias_std(calibration)
        self._tracks = {
            name: ComplementaryFilterTrack(name, aid, gains or PAPER_GAINS, gravity, *stds)
            for name in self._filters
            if name != JOINT
        }

    def reset(self) -> None:
        """Take the next tick's time as one of another beginning."""
        self._joint.reset()
        for track in self._tracks.values():
            track.reset()

    def take(
        self, t: FloatArray, inputs: RatesAndForces, aiding: AidValues = NO_AID
    ) -> tuple[AttitudeReading, tuple[FilterReading, ...]] | None:
        """Take ends ``t`` (n,) [s] and inputs of a tick; None while aligning.

        The tuple is empty where only the joint filter was asked for.
        """
        found = self._joint.take(t, inputs, aiding)
        read = {name: track.take(t, inputs, aiding) for name, track in self._tracks.items()}
        if found is None:
            return None
        all_read = [
            joint_filter_reading(found, self._aid) if name == JOINT else read[name] for name in self._filters
        ]
        readings = tuple(one for one in all_read if one is not None)
        if not self._tracks or len(readings) < len(self._filters):
            return found, ()
        return (found if readings[0].name == JOINT else self._read_by(readings[0], found)), readings

    def _read_by(self, one: FilterReading, found: AttitudeReading) -> AttitudeReading:
        """Return the reading with a filter's attitude in the place of the joint filter's; it has no sigma."""
        residual = float(np.degrees(inclination(-self._joint.smoothed_force, np.array(one.down))))
        return replace(found, roll=one.roll, pitch=one.pitch, bias=one.bias, sigma=float("nan"), residual=residual)


def compile_filters() -> None:
    """Compile all filters. The result is kept on the disk, so that only the first run takes a minute."""
    compile_filter()
    t: FloatArray = 0.01 * np.arange(300.0)
    still = RatesAndForces(np.zeros((300, 3)), np.tile([0.0, 0.0, -9.8], (300, 1)))
    ComplementaryFilterTrack("mixer", "none").take(t, still)


def joint_filter_reading(found: AttitudeReading, aid: str) -> FilterReading:
    """Return the joint filter's reading as a filter's."""
    d0, d1, d2 = down_of(np.radians(found.roll), np.radians(found.pitch)).tolist()
    return FilterReading(JOINT, f"Kalman filter, aid {aid}", found.roll, found.pitch, (d0, d1, d2), found.bias)
