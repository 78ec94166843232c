"""A calibration applied to a source as `OutputRequest` asks, written to a file that is complete or absent."""

import json
import sys
import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import history
from procedures.arrays import FloatArray
from procedures.campaign.campaign import UNKNOWN
from procedures.effects.term.inputs import AUXILIARY
from procedures.units import STANDARD_GRAVITY
from station.applying.checked_samples import CheckedSamples, Survey, survey
from station.applying.log_source import refuse_other_units
from station.applying.source import Samples, Source
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.output_frame import Frame
from station.calibrated.remaining_uncertainty import lacking
from station.calibration import Calibrated, Calibration, calibration_of
from station.errors import DataRefused
from station.files.atomic_file import refuse_own, write_file_pair, write_json
from station.files.calibrated_sample_writers import SampleColumns, writer_for
from station.files.calibration_document import doubts
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS
from station.results.solution_json import software_version
from station.text import plural

SUFFIX = {"m/s2": "m_s2", "rad/s": "rad_s", "deg/s": "deg_s", "deg/h": "deg_h", "cm/s2": "cm_s2",
          "mdeg/s": "mdeg_s", "mrad/s": "mrad_s"}  # fmt: skip
SI = ("m/s2", "rad/s")


@dataclass(frozen=True, slots=True)
class OutputRequest:
    """How samples are wanted: ``units`` of force and rate, ``frame``, ``axes`` (docs/how-to/applying.md).

    With ``force`` they are written even if they are physically impossible.
    """

    frame: Frame = "sensor"
    axes: str | None = None
    units: tuple[str, str] = SI
    force: bool = False


def axes_of(source: Source, asked: OutputRequest) -> str | None:
    """Return the axes that go with the frame: as asked, of a cube else as the source is mounted."""
    return asked.axes or (source.stated.mounting if asked.frame == "cube" else None)


def names_of(source: Source, asked: OutputRequest) -> tuple[str, ...]:
    """Return the names of the columns that are written."""
    force, rate = (SUFFIX.get(unit, unit) for unit in asked.units)
    names = ["t_s", *(f"f_{axis}_{force}" for axis in "xyz"), *(f"omega_{axis}_{rate}" for axis in "xyz")]
    return (*names, *(["temp_c"] if source.stated.temperature else []), *source.stated.auxiliary)


def columns_of(block: Samples, got: Calibrated, source: Source, asked: OutputRequest) -> list[FloatArray]:
    """Return a block's columns (n,), in the units of their names."""
    per_force = ACCEL_UNITS[asked.units[0]] / STANDARD_GRAVITY
    per_rate = GYRO_UNITS[asked.units[1]] / GYRO_UNITS["rad/s"]
    force = got.specific_force if asked.units[0] == SI[0] else got.specific_force * per_force
    rate = got.angular_rate if asked.units[1] == SI[1] else got.angular_rate * per_rate
    unknown = np.full(len(block.t), np.nan)
    columns = [block.t, *force.T, *rate.T]
    if source.stated.temperature:
        columns.append(unknown if block.temperature is None else block.temperature)
    return columns + [block.auxiliary.get(name, unknown) for name in source.stated.auxiliary]


def document_of(
    source: Source, calibration: Calibration, found: Survey, asked: OutputRequest, samples: int,
    spans: list[Calibrated], warnings: tuple[str, ...],
) -> dict[str, Any]:  # fmt: skip
    """Return applied/1: what is to know of the file next to it, ``spans`` one a block."""

    def of(name: str) -> list[Any]:
        values = np.concatenate([getattr(each, name) for each in spans])
        return [[None if np.isnan(v) else v for v in row] for row in values.tolist()]

    known = calibration.document
    about = {
        name: known[name] for name in ("model", "serial", "accepted_utc", "status", "valid_until") if name in known
    }
    return {
        "format": "applied/1", "input": source.stated.name, "samples": samples, "period_s": found.period,
        "frame": asked.frame, "axes": axes_of(source, asked), "mounting": source.stated.mounting,
        "units": list(asked.units), "software": software_version(),
        "calibration": {**about, "sha256": calibration.sha256}, "effects": list(calibration.effects),
        "warnings": list(warnings),
        "spans_s": of("spans"), "specific_force_std_m_s2": of("specific_force_std"),
        "angular_rate_std_rad_s": of("angular_rate_std"),
    }  # fmt: skip


EVERY_S = 1.0  # on a terminal
EVERY_LINE_S = 10.0  # elsewhere, a line each
SILENT_S = 2.0  # at the beginning


class Progress:
    """Says how far it is, now and then."""

    def __init__(self) -> None:
        self._is_screen, self._begin, self._has_reported = sys.stderr.isatty(), time.monotonic(), False
        self._next = self._begin + SILENT_S

    def at(self, done: float, samples: int) -> None:
        """Say that a share ``done``, 0 to 1, and so many samples are behind."""
        now = time.monotonic()
        if now < self._next or not done > 0:
            return
        left = (now - self._begin) * (1 / done - 1)
        self._next = now + (EVERY_S if self._is_screen else EVERY_LINE_S)
        self._has_reported = True
        text = f"{100 * done:.0f} %, {samples} samples, {left:.0f} s left"
        sys.stderr.write(f"\r{text}   " if self._is_screen else f"{text}\n")
        sys.stderr.flush()

    def end(self) -> None:
        """End the line on a terminal."""
        if self._is_screen and self._has_reported:
            sys.stderr.write("\n")


def apply_to(
    source: Source,
    calibration: Calibration,
    out: Path,
    asked: OutputRequest,
    progress: Progress,
    known: Path | None = None,
) -> dict[str, Any]:
    """Write calibrated samples to ``out`` and `applied/1`, what is to know of them, to ``out.json``; return that.

    ``known`` is the file that the calibration was read from, if it was.

    Raise `DataRefused` if source and calibration do not go together, an effect's input is not there, or the data
    break a rule, and `CannotWrite` if ``out`` cannot be written.
    """
    _refuse_unlike(source, calibration)
    writer = writer_for(out)
    refuse_own([out, _document_path(out)], _read(source, known))
    found = survey(source)
    names = names_of(source, asked)
    columns = SampleColumns(names, found.rows, asked.frame, asked.units == SI)
    with write_file_pair(out, _document_path(out)) as (aside, document):
        written = writer(aside, columns)
        try:
            applied = _run(source, calibration, found, asked, written.write, progress)
            written.finish()
        except BaseException:
            written.abandon()
            raise
        finally:
            progress.end()
        write_json(document, {**applied, "columns": list(names)})
    return applied


def _read(source: Source, known: Path | None) -> list[Path]:
    """Return every file that must not be written over: of a folder all that is in it."""
    named = Path(source.stated.name)
    inside = [path for path in named.rglob("*") if path.is_file()] if named.is_dir() else [named]
    return [*inside, *([known] if known else [])]


def _run(
    source: Source, calibration: Calibration, found: Survey, asked: OutputRequest, write: Any, progress: Progress
) -> dict[str, Any]:
    is_of_counts = calibration.output == "counts"
    samples = CheckedSamples(source, found, is_of_counts)
    period = found.period if is_of_counts else None
    stream = calibration.stream(
        period, frame=asked.frame, output=calibration.output, axes=axes_of(source, asked), force=asked.force
    )
    stream.physics.where, stream.physics.go_on = source.stated.name, "continue with --force"
    stream.physics.axes = np.array(source.stated.accelerometers)
    count, spans, none = 0, list[Calibrated](), np.empty((0, 3))
    for block in samples:
        got = stream.apply(block.values, block.t, block.temperature, block.auxiliary)
        write(columns_of(block, got, source, asked))
        count += len(block.t)
        spans.append(replace(got, t=none[:, 0], specific_force=none, angular_rate=none))  # samples are let go
        progress.at(block.done, count)
    if not count:
        raise DataRefused(source.stated.name, None, "no sample", "rows with a number in time and outputs")
    spans.append(last := stream.apply(np.empty((0, 6)), np.empty(0), last=True))
    left = [
        f"{source.stated.damage}: samples until then are here" if source.stated.damage else "",
        f"{plural(samples.lost, 'row')} without a measured number in time or outputs: discarded"
        if samples.lost
        else "",
        *(
            f"{plural(rows, 'row')} with {number:g}, a number that stands for no sample: discarded"
            for number, rows in samples.sentinels.items()
        ),
        f"repeated rows discarded: {samples.repeated}" if samples.repeated else "",
    ]
    text = (*filter(None, left), *doubts(calibration.document, datetime.now(UTC)), *last.warnings)
    return document_of(source, calibration, found, asked, count, spans, text)


def _refuse_unlike(source: Source, calibration: Calibration) -> None:
    stated, document = source.stated, calibration.document
    for what, theirs, ours in (
        ("serial", stated.serial, calibration.serial), ("model", stated.model, calibration.model)
    ):  # fmt: skip
        if theirs not in {None, UNKNOWN} and ours != UNKNOWN and theirs != ours:
            raise DataRefused(
                stated.name, None, f"{what} {theirs}", f"{ours}, as the calibration", "name that unit's own"
            )
    is_of_counts = calibration.output == "counts"
    is_rate = stated.output == "rate" or (stated.output is None and bool(stated.rates_in))
    if is_of_counts and is_rate:
        found = f"rates{f' in {stated.rates_in}' if stated.rates_in else ''}"
        raise DataRefused(stated.name, None, found, "counts, as the calibration", "name the columns of counts")
    if not is_of_counts and stated.output in {"increments", "cumulative"}:
        expected = "rates, as the calibration"
        raise DataRefused(stated.name, None, f"counts ({stated.output})", expected, "use a calibration of counts")
    if not is_of_counts:
        refuse_other_units(stated, document)
    model = CalibrationModel.of(document)
    model = model.without(tuple(name for name in model.taken_off if name not in calibration.effects))
    channels = [name.removeprefix(AUXILIARY) for name in stated.auxiliary]
    lacks = lacking(model, document, channels, stated.triads, has_temperature=stated.temperature)
    if lacks:
        sizes = ", ".join(f"{name} ({size or 'of unknown size'})" for name, size in lacks.items())
        remedy = f"name its column, or continue with {' '.join(f'--without {name}' for name in lacks)}"
        raise DataRefused(stated.name, None, f"no data for these error terms: {sizes}", "their inputs", remedy)


def _document_path(out: Path) -> Path:
    return out.with_name(f"{out.name}.json")


def newest_of(serial: str, database: str | None, model: str | None) -> Calibration:
    """Return it; ``model`` separates units of one serial number.

    Raise `DataRefused` if there is none, or there are several models of this serial number.
    """
    with open_db(database) as opened, opened.read() as session:
        documents = [(json.loads(row.document), row.sha256) for row in history(session, serial)]
    models = sorted({str(document["model"]) for document, _ in documents})
    wanted = model if model in models else models[0] if len(models) == 1 else None
    if wanted is None:
        found = (
            f"models {', '.join(models)} of serial {serial}" if models else f"no calibration of serial {serial}"
        )
        expected = "a file of calibration/1, or a serial number that is stored"
        raise DataRefused("the database", None, found, expected, "give --calibration FILE")
    document, sha256 = next(each for each in reversed(documents) if each[0]["model"] == wanted)
    return calibration_of(document, sha256[:12])
