"""A calibration applied block by block: the same numbers as applied to a whole recording at once."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from procedures.arrays import FloatArray
from procedures.effects.term.inputs import AUXILIARY
from procedures.frames import TRIADS
from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY
from station.calibrated.applied_calibration import CalibratedInputs, CalibrationModel
from station.calibrated.correction_inputs import WARMTH, Surroundings
from station.calibrated.physics_check import PhysicsCheck
from station.calibrated.remaining_uncertainty import SpanSigmas, size_of
from station.errors import DataRefused

LARGEST = 1e30  # of an output a second: beyond it no device counts, and squares of it are no numbers


def numbers(values: Any, name: str) -> FloatArray:
    """Return (n,) or (n, k) numbers in their own unit; raise `DataRefused` for all else, named ``name``."""
    try:
        found = np.asarray(values)
    except (ValueError, TypeError):  # rows of different lengths
        raise DataRefused(name, None, "rows of different lengths", "an array of numbers", "correct it") from None
    if found.size and found.dtype.kind not in "buif":
        expected = "numbers of a kind such as float64"
        raise DataRefused(name, None, f"an array of {found.dtype}", expected, "convert it")
    return found.astype(np.float64, copy=False)


BLOCK = 2**14  # samples, whose arrays stay in a processor's cache
ROWS = {"gyroscope": slice(0, 3), "accelerometer": slice(3, 6)}  # of six outputs
TOLERANCE_K = 0.5  # beyond the temperatures of a calibration, before a warning
MAX_UNSETTLED = 1e-3  # of all samples, and one in any case: more are a wrong calibration, not a few wild outputs


@dataclass(frozen=True, eq=False)
class Calibrated:
    """What the sensors felt at n samples, and what the calibration leaves of it in m spans of a minute.

    Attributes
    ----------
    t : (n,) [s], as given
    specific_force : (n, 3) [m/s2], in the frame that was asked for; nan of a triad that is not there
        and where its effects do not settle
    angular_rate : (n, 3) [rad/s], relative to inertial space, in the same frame
    spans : (m, 2) [s], first and last sample of each
    specific_force_std, angular_rate_std : (m, 3) [m/s2], [rad/s], 1 sigma of what the uncertainty of the
        calibration leaves in a span; noise and quantisation are not in it
    warnings : what to know, in words; empty if nothing
    """

    t: FloatArray
    specific_force: FloatArray
    angular_rate: FloatArray
    spans: FloatArray
    specific_force_std: FloatArray
    angular_rate_std: FloatArray
    warnings: tuple[str, ...] = ()


class CalibrationStream:
    """Applies a calibration part by part; lags and hysteresis go on. Made by `Calibration.stream`.

    ``model`` is that of a calibration/1 ``document``; ``C`` (3, 3) takes IMU axes to what is wanted.

    ``period`` [s] is that of a sample's interval, None where the device sends rates.
    """

    def __init__(
        self, model: CalibrationModel, document: Mapping[str, Any], C: FloatArray, period: float | None,
        *, force: bool = False,
    ) -> None:  # fmt: skip
        self._model, self._document, self._C = model, document, C
        self._per_second = 1.0 if period is None else 1.0 / period
        self._follower = model.follower()
        self._sigmas = SpanSigmas(model, document, C)
        self._held = dict[str, FloatArray]()
        self._last, self._samples, self._without_temperature = nan, 0, 0
        self._unsettled, self._first_unsettled = 0, nan
        self._lost = set[str]()  # triads with samples that do not settle
        self._range = list[float]()
        self._left, self._left_in = dict[str, str](), Counter[str]()  # why, and in how many samples, by effect
        self.physics = PhysicsCheck(period, _offset(model, C), is_of_counts=period is not None, force=force)
        self._impossible = ""  # what is, in a sentence, where it goes on all the same
        self._outside = 0  # samples, of the calibration's temperatures

    def apply(
        self, counts: ArrayLike, t: ArrayLike, temperature: ArrayLike | None = None,
        auxiliary: Mapping[str, ArrayLike] | None = None, *, magnetic: ArrayLike | None = None, last: bool = False,
    ) -> Calibrated:  # fmt: skip
        """Return what the sensors felt, arguments as of `station.calibration.Calibration.apply`.

        ``spans`` and their sigmas are of minutes that are full, with ``last`` of the one that is not, too. Raise
        `DataRefused` if arrays do not go together, time goes back, or at the end if too many samples do not settle
        or what they are is physically impossible (without ``force``).
        """
        values, at = numbers(counts, "counts"), numbers(t, "t")
        n = self._checked(values, at)
        known = None if temperature is None else _column(temperature, n, "temperature")
        named: Any = auxiliary or {}
        if not isinstance(named, Mapping):
            found = type(auxiliary).__name__
            raise DataRefused("auxiliary", None, found, "channels by name", "give a dict")
        channels = {
            name.removeprefix(AUXILIARY): _column(value, n, f"auxiliary {name}") for name, value in named.items()
        }
        field = None if magnetic is None else numbers(magnetic, "magnetic")
        if field is not None and field.shape != (n, 3):
            raise DataRefused("magnetic", None, f"shape {field.shape}", f"({n}, 3)", "give one row per sample")
        f, omega = np.empty((n, 3)), np.empty((n, 3))
        for begin in range(0, n, BLOCK):
            part = slice(begin, min(begin + BLOCK, n))
            around = self._around(
                at[part], None if known is None else known[part],
                {name: value[part] for name, value in channels.items()}, None if field is None else field[part],
            )  # fmt: skip
            self._take(values[part], around, f[part], omega[part])
            self.physics.take(np.asarray(values[part], np.float64), at[part], f[part], omega[part])
        if last and self._unsettled > max(1, MAX_UNSETTLED * self._samples):
            self._refuse_unsettled()
        if last and (impossible := self.physics.refusal()) is not None:
            if not self.physics.force:
                raise impossible
            self._impossible = str(impossible)
        return Calibrated(at, f, omega, *self._sigmas.ended(is_last=last), self._warnings())

    def _warnings(self) -> tuple[str, ...]:
        """Return what is to know so far, in words."""
        texts = [
            f"{name} is not corrected{self._of(self._left_in[name])}, {why}" for name, why in self._left.items()
        ]
        limits = self._document.get("temperature_range_c")
        if limits and self._range:
            low, high = self._range
            if low < limits[0] - TOLERANCE_K or high > limits[1] + TOLERANCE_K:
                texts.append(
                    f"temperature was {low:.1f} to {high:.1f} degC, the calibration's {limits[0]:.1f} to "
                    f"{limits[1]:.1f} degC{self._of(self._outside)}: outside this range the calibration is not "
                    "valid"
                )
        if self._without_temperature and self._range:
            texts.append(
                f"the first {self._without_temperature} samples have no temperature: temperature effects are not "
                "corrected"
            )
        if self._unsettled:
            texts.append(f"found {self._unsettled_text()}: nan there")
        if self._impossible:
            texts.append(self._impossible)
        if self._document.get("status") == "measured":
            texts.append(
                f"the calibration was measured without valid references: {self._document.get('status_reason', '')}"
            )
        return tuple(texts)

    def _of(self, count: int) -> str:
        return "" if count == self._samples else f", in {count} of {self._samples} samples"

    def _unsettled_text(self) -> str:
        names = [name for name in self._model.taken_off if name.split(".")[0] in self._lost]
        of = f"{self._unsettled} of {self._samples} samples, the first at {self._first_unsettled:.9g} s"
        return f"{', '.join(names)} not to converge in {of}"

    def _refuse_unsettled(self) -> None:
        expected = f"at most 1 in {1 / MAX_UNSETTLED:.0f}, because error terms are small against the input"
        remedy = "correct the calibration or the data, or leave error terms out"
        raise DataRefused("calibration", None, self._unsettled_text(), expected, remedy)

    def _checked(self, values: Any, t: FloatArray) -> int:
        n = len(t) if t.ndim == 1 else -1
        if n < 0 or values.shape != (n, 6):
            found = f"counts of shape {values.shape} and t of {t.shape}"
            raise DataRefused(
                "counts", None, found, "(n, 6) and (n,)", "give gyroscopes x, y, z, accelerometers x, y, z"
            )
        before = np.concatenate(([self._last], t[:-1]))
        if (bad := np.flatnonzero(~(t > before) & ~np.isnan(before))).size or not np.isfinite(t).all():
            row = int(bad[0]) if bad.size else int(np.flatnonzero(~np.isfinite(t))[0])
            found = f"t {t[row]:.9g} after {before[row]:.9g} in sample {self._samples + row}"
            raise DataRefused("t", None, found, "times that rise from sample to sample", "correct it")
        if n:
            self._last = float(t[-1])
        self._samples += n
        return n

    def _around(
        self, t: FloatArray, temperature: FloatArray | None, auxiliary: dict[str, FloatArray],
        magnetic: FloatArray | None,
    ) -> Surroundings:  # fmt: skip
        signals = self._follower.take(t, temperature)
        warm = signals[WARMTH][np.isfinite(signals[WARMTH])] + 25.0
        self._without_temperature += len(t) - len(warm)
        if len(warm):
            low, high = self._document.get("temperature_range_c") or (-np.inf, np.inf)
            self._outside += int(np.sum((warm < low - TOLERANCE_K) | (warm > high + TOLERANCE_K)))
            both = [float(warm.min()), float(warm.max()), *self._range]
            self._range = [min(both), max(both)]
        named = {name: self._without_gaps(name, value[:, None])[:, 0] for name, value in auxiliary.items()}
        field = None if magnetic is None else self._without_gaps(" magnetic", magnetic)
        return Surroundings(magnetic=field, auxiliary=named, t=t, signals=signals)

    def _without_gaps(self, name: str, values: FloatArray) -> FloatArray:
        """Return a channel (n, k) whose samples without a number have that of the sample before."""
        before = self._held.get(name, np.full(values.shape[1], nan))
        known = np.isfinite(values).all(axis=1)
        if not known.all():
            at = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
            values = np.where(at[:, None] >= 0, values[at], before)
        self._held[name] = values[-1]
        return values

    @np.errstate(over="ignore")  # of counts beyond all bounds, which are none
    def _take(self, values: Any, around: Surroundings, f: FloatArray, omega: FloatArray) -> None:
        rates = dict[str, FloatArray | None]()
        for name, columns in ROWS.items():
            rate = values[:, columns] * self._per_second
            rate[~(np.abs(rate) < LARGEST)] = nan
            is_there = name in self._model.triads and not np.isnan(rate).all()
            rates[name] = rate if is_there else None
        found = self._model.inputs(rates["accelerometer"], rates["gyroscope"], around)
        if found.unsettled.any():
            assert around.t is not None
            self._first_unsettled = np.fmin(self._first_unsettled, around.t[found.unsettled.argmax()])
            self._unsettled += int(found.unsettled.sum())
            for name, u in (("accelerometer", found.f), ("gyroscope", found.omega)):
                if u is not None and np.isnan(u[found.unsettled]).any():
                    self._lost.add(name)
        self._note_left(found, [name for name in TRIADS if rates[name] is not None], len(f))
        for u, into, unit in ((found.f, f, STANDARD_GRAVITY), (found.omega, omega, RAD_PER_DEG)):
            if u is None:
                into[:] = nan
            else:
                np.matmul(u, unit * self._C.T, out=into)
        self._sigmas.take(found, around)

    def _note_left(self, found: CalibratedInputs, triads: list[str], samples: int) -> None:
        """Note what was not corrected of the triads that are there, and in how many samples."""
        for name, reason in (sentence.split(": ", 1) for sentence in found.not_applied):
            if name.split(".")[0] not in triads:
                continue
            self._left_in[name] += samples
            if name not in self._left:
                size = size_of(self._model, self._document, name)
                self._left[name] = f"{reason}{size and f' ({size})'}"


def _offset(model: CalibrationModel, C: FloatArray) -> FloatArray:
    """Return the bias that is subtracted from the specific force (3,) [m/s2], in the frame of the output."""
    if (triad := model.triads.get("accelerometer")) is None:
        return np.zeros(3)
    found: FloatArray = STANDARD_GRAVITY * (C @ triad.inverse @ triad.D)
    return found


def _column(values: Any, n: int, name: str) -> FloatArray:
    found = numbers(values, name)
    if found.shape != (n,):
        raise DataRefused(
            name, None, f"shape {found.shape}", f"({n},)", "give one value per sample, nan where unknown"
        )
    return found
