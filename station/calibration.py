"""A stored calibration applied in a program of your own: the library, and all of it (docs/reference/library.md).

>>> calibration = load("calibration.json")                      # doctest: +SKIP
>>> found = calibration.apply(counts, t, temperature=T)         # doctest: +SKIP
>>> found.specific_force, found.angular_rate, found.warnings    # doctest: +SKIP
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fixtures_db.hash_chain import canonical, digest
from procedures.counts.sample_times import own_period
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.calibrated_stream import Calibrated, CalibrationStream, numbers
from station.calibrated.output_frame import Frame, rotation_to
from station.errors import DataRefused
from station.files.calibration_document import checked_calibration, is_of_counts, read_calibration

__all__ = ["Calibrated", "Calibration", "CalibrationStream", "DataRefused", "calibration_of", "load"]

RATE_TOLERANCE = 0.01  # relative, of a period that is stated

Output = Literal["counts", "rates"]


@dataclass(frozen=True, eq=False)
class Calibration:
    """A `calibration/1`; make it by `load`. It holds no file and no database, and may be pickled.

    Attributes
    ----------
    model, serial : of the unit that it is of
    output : "counts" or "rates", what it is applied to
    effects : names of the effects that it takes off
    document : calibration/1 as it was read (docs/reference/file-formats.md)
    sha256 : of the document's one text, by which the database knows it
    """

    model: str
    serial: str
    output: Output
    effects: tuple[str, ...]
    document: Mapping[str, Any]

    @property
    def sha256(self) -> str:
        """SHA-256 of the document's one text; empty of a document that no JSON holds."""
        try:
            return digest(canonical(self.document))
        except (ValueError, TypeError, RecursionError):
            return ""

    def apply(
        self,
        counts: ArrayLike,
        t: ArrayLike,
        temperature: ArrayLike | None = None,
        auxiliary: Mapping[str, ArrayLike] | None = None,
        frame: Frame = "sensor",
        output: Output = "counts",
        *,
        magnetic: ArrayLike | None = None,
        period: float | None = None,
        axes: str | None = None,
        force: bool = False,
    ) -> Calibrated:
        """Return what the sensors felt.

        Parameters
        ----------
        counts : (n, 6), gyroscopes x, y, z and accelerometers x, y, z; nan in all of a triad that is not there.
            Counts are those of each sample alone, in its interval; with ``output="rates"`` what a device that
            sends rates sends, in its own unit.
        t : (n,) [s], when each sample's interval ended; rises
        temperature : (n,) [degC], nan where a sample has none: then it is that of the sample before
        auxiliary : other channels by name, each (n,), as the calibration's effects name them, with or without aux_
        frame : "sensor", the IMU's own axes; "cube", which it was calibrated in; "frd", forward-right-down
        output : "counts" or "rates"
        magnetic : (n, 3) [uT], field in the IMU's axes
        period : [s], of a sample's interval; None: the pace of ``t``, gaps left out. A rate is counts over it
        axes : of "frd": which IMU axes point forward, right and down, "x,-y,-z" if not stated; of "cube": along
            which cube axes the IMU's point, "+x,+y,+z" if not stated
        force : whether to return, with a warning, what is physically impossible

        Raises
        ------
        DataRefused
            In one line: if shapes or kind of output do not go together, time goes back, the period is more than
            1 % off the pace of ``t``, or effects do not settle in more than 1 of 1000 samples: those few are nan.
            Without ``force`` also if the unit rests and its specific force is not 9.8 m/s2 within 20 % (code
            E-GRAVITY), or it rotates across gravity (E-RATE-AT-REST).
        """
        at = numbers(t, "t")
        if output == "counts":
            period = _period(at, period)
        stream = self.stream(period, frame=frame, output=output, axes=axes, force=force)
        return stream.apply(counts, at, temperature, auxiliary, magnetic=magnetic, last=True)

    def stream(
        self, period: float | None, *, frame: Frame = "sensor", output: Output = "counts", axes: str | None = None,
        force: bool = False,
    ) -> CalibrationStream:  # fmt: skip
        """Return what applies it to one part of a recording after the other: the same numbers as at once.

        Arguments and refusals as of `apply`; whether the whole is physically possible the last part says.
        """
        if output != self.output:
            raise DataRefused(
                "calibration", None, f"one of {self.output}", f"one of {output}, which are given",
                f"state output={self.output!r} if that is what they are",
            )  # fmt: skip
        whole = CalibrationModel.of(self.document)
        model = whole.without(tuple(name for name in whole.taken_off if name not in self.effects))
        if output == "counts" and not _is_period(period):
            raise DataRefused(
                "period", None, f"{period!r}"[:60], "a sample interval in seconds, above zero", "say it"
            )
        C = rotation_to(frame, axes)
        known = period if output == "counts" else None
        return CalibrationStream(model, self.document, C, known, force=force)

    def without(self, *names: str) -> "Calibration":
        """Return it without some of its effects, which then are left in.

        Raises
        ------
        DataRefused
            If it does not have one of them.
        """
        if unknown := [name for name in names if name not in self.effects]:
            had = ", ".join(self.effects) or "one without effects"
            raise DataRefused("calibration", None, f"no effect {unknown[0]}", had, "name one of them")
        return replace(self, effects=tuple(name for name in self.effects if name not in names))


def _period(t: NDArray[np.float64], stated: float | None) -> float:
    """Return the period [s] of samples at ``t`` (n,): as stated, if they are within 1 % of it, else their pace."""
    if stated is not None and not _is_period(stated):
        raise DataRefused("period", None, f"{stated!r}"[:60], "seconds, above 0", "correct period")
    if t.ndim != 1:
        raise DataRefused("t", None, f"{t.ndim} dimensions", "a time for each sample, (n,)", "correct t")
    if len(t) < 2 or not np.all(np.diff(t) > 0):
        if stated is None or len(t) > 1:
            raise DataRefused(
                "t", None, "no times that rise", "two at least, rising from sample to sample", "correct t"
            )
        return stated
    pace = own_period(t)
    if stated is not None and abs(pace / stated - 1) > RATE_TOLERANCE:
        text = f"samples {pace:.6g} s apart"
        raise DataRefused(
            "t", None, text, f"{stated:.6g} s within 1 %, as stated by period=", "correct one of them"
        )
    return pace if stated is None else stated


def _is_period(value: object) -> bool:
    return isinstance(value, int | float) and isfinite(value) and value > 0


def load(path: str | Path) -> Calibration:
    """Return the calibration in a file of calibration/1.

    Raises
    ------
    DataRefused
        If there is none, or it lacks what is needed: in one line.
    """
    if not isinstance(path, str | Path):
        raise DataRefused("path", None, type(path).__name__, "the path of a calibration/1", "give it as text")
    return calibration_of(read_calibration(Path(path)), str(path))


def calibration_of(document: Mapping[str, Any], where: str = "calibration") -> Calibration:
    """Return the calibration of a calibration/1 that is parsed already; ``where`` is what refusals name."""
    checked = checked_calibration(dict(document) if isinstance(document, Mapping) else document, where)
    model = CalibrationModel.of(checked)
    output: Output = "counts" if is_of_counts(checked) else "rates"
    effects = model.taken_off
    return Calibration(str(checked["model"]), str(checked["serial"]), output, effects, checked)
