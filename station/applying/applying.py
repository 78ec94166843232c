"""A calibration applied to a source, into a file that is there whole or not at all."""

import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import UNKNOWN
from procedures.effects.term.inputs import AUXILIARY
from procedures.units import STANDARD_GRAVITY
from station.applying.checked_samples import LOOKED_AT, CheckedSamples, refuse_other_kind
from station.applying.progress import Progress
from station.applying.source import Samples, Source
from station.applying.survey import Survey, survey
from station.applying.told_units import refuse_other_units
from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.left_in import lacking
from station.calibrated.target_frame import Frame
from station.calibration import Calibrated, Calibration
from station.errors import CannotWrite, DataRefused, cannot_write
from station.files.atomic_file import refuse_own, sync_folder, write_json
from station.files.calibration_document import doubts
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS
from station.files.sample_files import writer_for
from station.files.sample_files.sample_file import SampleColumns

SUFFIX = {"m/s2": "m_s2", "rad/s": "rad_s", "deg/s": "deg_s", "deg/h": "deg_h", "cm/s2": "cm_s2",
          "mdeg/s": "mdeg_s", "mrad/s": "mrad_s"}  # fmt: skip
SI = ("m/s2", "rad/s")


@dataclass(frozen=True, slots=True)
class Asked:
    """How samples are wanted: ``units`` of force and rate, ``frame``, ``axes`` (docs/applying.md)."""

    frame: Frame = "sensor"
    axes: str | None = None
    units: tuple[str, str] = SI


@dataclass(frozen=True, slots=True, eq=False)
class Applied:
    """What came of it: samples, the period [s], the document beside the file, and what to know, in words."""

    samples: int
    period: float
    document: Mapping[str, Any]
    warnings: tuple[str, ...]


def apply_to(
    source: Source,
    calibration: Calibration,
    out: Path,
    asked: Asked,
    progress: Progress,
    known: Path | None = None,
) -> Applied:
    """Write calibrated samples to ``out``, and what is to know of them to ``out.json``.

    ``known`` is the file that the calibration was read from, if it was.

    Raises
    ------
    DataRefused
        If source and calibration do not go together, an effect's input is not there, or the data break a rule.
    CannotWrite
        If ``out`` cannot be written.
    """
    _refuse_unlike(source, calibration)
    writer = writer_for(out)
    refuse_own([out, _beside(out)], _read(source, known))
    found = survey(source)
    names = _names(source, asked)
    columns = SampleColumns(names, found.rows, asked.frame, asked.units == SI)
    with _aside(out) as aside:
        written = writer(aside, columns)
        try:
            applied = _run(source, calibration, found, asked, written.write, progress)
            written.finish()
        except BaseException:
            written.abandon()
            raise
        write_json(_beside(out), {**applied.document, "columns": list(names)})
    return applied


def _read(source: Source, known: Path | None) -> list[Path]:
    """Return every file that must not be written over: of a folder all that is in it."""
    named = Path(source.told.name)
    inside = [path for path in named.rglob("*") if path.is_file()] if named.is_dir() else [named]
    return [*inside, *([known] if known else [])]


def _run(
    source: Source, calibration: Calibration, found: Survey, asked: Asked, write: Any, progress: Progress
) -> Applied:
    is_of_counts = calibration.output == "counts"
    samples = CheckedSamples(source, found, is_of_counts)
    axes = asked.axes or (source.told.mounting if asked.frame == "cube" else None)
    period = found.period if is_of_counts else None
    stream = calibration.stream(period, frame=asked.frame, output=calibration.output, axes=axes)
    count, spans, warnings = 0, list[Calibrated](), tuple[str, ...]()
    for block in samples:
        got = stream.apply(block.values, block.t, block.temperature, block.auxiliary)
        if count < LOOKED_AT:
            refuse_other_kind(got.specific_force, found.period, block.where, is_of_counts=is_of_counts)
        write(_columns(block, got, source, asked))
        count += len(block.t)
        spans.append(_of_spans(got))
        warnings = got.warnings
        progress.at(block.done, count)
    if not count:
        raise DataRefused(source.told.name, None, "no sample", "rows with a number in time and outputs")
    last = stream.apply(np.empty((0, 6)), np.empty(0), last=True)
    spans.append(_of_spans(last))
    progress.end()
    left = [
        f"{samples.lost} rows without a number in time or outputs: left out" if samples.lost else "",
        f"{samples.repeated} rows that repeat the one before: left out" if samples.repeated else "",
    ]
    said = (*filter(None, left), *doubts(calibration.document, datetime.now(UTC)), *warnings)
    return Applied(count, found.period, _document(source, calibration, found, asked, count, spans, said), said)


def _refuse_unlike(source: Source, calibration: Calibration) -> None:
    told, document = source.told, calibration.document
    for what, theirs, ours in (
        ("serial", told.serial, calibration.serial), ("model", told.model, calibration.model)
    ):  # fmt: skip
        if theirs not in {None, UNKNOWN} and ours != UNKNOWN and theirs != ours:
            raise DataRefused(
                told.name, None, f"{what} {theirs}", f"{ours}, which the calibration is of", "name that unit's own"
            )
    is_of_counts = calibration.output == "counts"
    is_rate = told.output == "rate" or (told.output is None and bool(told.rates_in))
    if is_of_counts and is_rate:
        found = f"rates{f' in {told.rates_in}' if told.rates_in else ''}"
        raise DataRefused(
            told.name, None, found, "counts, which the calibration is of", "name the columns of counts"
        )
    if not is_of_counts and told.output in {"increments", "cumulative"}:
        expected = "rates, which the calibration is of"
        raise DataRefused(told.name, None, f"counts ({told.output})", expected, "take a calibration of counts")
    if not is_of_counts:
        refuse_other_units(told, document)
    model = CalibrationModel.of(document)
    model = model.without(tuple(name for name in model.taken_off if name not in calibration.effects))
    channels = [name.removeprefix(AUXILIARY) for name in told.auxiliary]
    lacks = lacking(model, document, channels, told.triads, has_temperature=told.temperature)
    if lacks:
        sizes = ", ".join(f"{name} ({size or 'of unknown size'})" for name, size in lacks.items())
        remedy = f"name its column, or go on with {' '.join(f'--without {name}' for name in lacks)}"
        raise DataRefused(told.name, None, f"nothing of what these effects need: {sizes}", "their inputs", remedy)


def _names(source: Source, asked: Asked) -> tuple[str, ...]:
    force, rate = (SUFFIX.get(unit, unit) for unit in asked.units)
    names = ["t_s", *(f"f_{axis}_{force}" for axis in "xyz"), *(f"omega_{axis}_{rate}" for axis in "xyz")]
    return (*names, *(["temp_c"] if source.told.temperature else []), *source.told.auxiliary)


def _columns(block: Samples, got: Calibrated, source: Source, asked: Asked) -> list[FloatArray]:
    per_force = ACCEL_UNITS[asked.units[0]] / STANDARD_GRAVITY
    per_rate = GYRO_UNITS[asked.units[1]] / GYRO_UNITS["rad/s"]
    force = got.specific_force if asked.units[0] == SI[0] else got.specific_force * per_force
    rate = got.angular_rate if asked.units[1] == SI[1] else got.angular_rate * per_rate
    unknown = np.full(len(block.t), np.nan)
    columns = [block.t, *force.T, *rate.T]
    if source.told.temperature:
        columns.append(unknown if block.temperature is None else block.temperature)
    return columns + [block.auxiliary.get(name, unknown) for name in source.told.auxiliary]


def _of_spans(got: Calibrated) -> Calibrated:
    """Return the spans alone, so that samples are let go."""
    none = np.empty((0, 3))
    return Calibrated(np.empty(0), none, none, got.spans, got.specific_force_std, got.angular_rate_std)


def _document(
    source: Source, calibration: Calibration, found: Survey, asked: Asked, samples: int, spans: list[Calibrated],
    warnings: tuple[str, ...],
) -> dict[str, Any]:  # fmt: skip
    def of(name: str) -> list[Any]:
        values = np.concatenate([getattr(each, name) for each in spans])
        return [[None if np.isnan(v) else v for v in row] for row in values.tolist()]

    known = calibration.document
    about = {
        name: known[name] for name in ("model", "serial", "accepted_utc", "status", "valid_until") if name in known
    }
    return {
        "format": "applied/1", "input": source.told.name, "samples": samples, "period_s": found.period,
        "frame": asked.frame, "units": list(asked.units),
        "calibration": about, "effects": list(calibration.effects), "warnings": list(warnings),
        "spans_s": of("spans"), "specific_force_std_m_s2": of("specific_force_std"),
        "angular_rate_std_rad_s": of("angular_rate_std"),
    }  # fmt: skip


def _beside(out: Path) -> Path:
    return out.with_name(f"{out.name}.json")


@contextmanager
def _aside(out: Path) -> Iterator[Path]:
    """Give a place beside ``out`` to write to, and put what is there in its place, unless something is raised."""
    if out.is_dir():
        raise CannotWrite(out, "a folder of this name is there")
    aside = out.with_name(f".{out.name}.{secrets.token_hex(6)}.tmp")
    try:
        yield aside
        os.replace(aside, out)
        sync_folder(out.parent)
    except OSError as error:
        raise error if isinstance(error, CannotWrite) else cannot_write(out, error) from error
    finally:
        shutil.rmtree(aside, ignore_errors=True) if aside.is_dir() else aside.unlink(missing_ok=True)
