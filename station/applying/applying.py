"""A calibration applied to a source, into a file that is there whole or not at all."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from procedures.campaign.campaign import UNKNOWN
from procedures.effects.term.inputs import AUXILIARY
from station.applying.checked_samples import CheckedSamples
from station.applying.output_request import SI, OutputRequest, axes_of, columns_of, document_of, names_of
from station.applying.progress import Progress
from station.applying.source import Source
from station.applying.survey import Survey, survey
from station.applying.unit_contradictions import refuse_other_units
from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.unapplied_effect_size import lacking
from station.calibration import Calibrated, Calibration
from station.errors import DataRefused
from station.files.atomic_file import refuse_own, write_json
from station.files.calibration_document import doubts
from station.files.sample_files import writer_for
from station.files.sample_files.sample_file import SampleColumns
from station.files.write_file_pair import write_file_pair
from station.text.plural import plural


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
    asked: OutputRequest,
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
    names = names_of(source, asked)
    columns = SampleColumns(names, found.rows, asked.frame, asked.units == SI)
    with write_file_pair(out, _beside(out)) as (aside, beside):
        written = writer(aside, columns)
        try:
            applied = _run(source, calibration, found, asked, written.write, progress)
            written.finish()
        except BaseException:
            written.abandon()
            raise
        finally:
            progress.end()
        write_json(beside, {**applied.document, "columns": list(names)})
    return applied


def _read(source: Source, known: Path | None) -> list[Path]:
    """Return every file that must not be written over: of a folder all that is in it."""
    named = Path(source.told.name)
    inside = [path for path in named.rglob("*") if path.is_file()] if named.is_dir() else [named]
    return [*inside, *([known] if known else [])]


def _run(
    source: Source, calibration: Calibration, found: Survey, asked: OutputRequest, write: Any, progress: Progress
) -> Applied:
    is_of_counts = calibration.output == "counts"
    samples = CheckedSamples(source, found, is_of_counts)
    period = found.period if is_of_counts else None
    stream = calibration.stream(
        period, frame=asked.frame, output=calibration.output, axes=axes_of(source, asked), force=asked.force
    )
    stream.physics.where, stream.physics.go_on = source.told.name, "continue with --force"
    stream.physics.axes = np.array(source.told.accelerometers)
    count, spans = 0, list[Calibrated]()
    for block in samples:
        got = stream.apply(block.values, block.t, block.temperature, block.auxiliary)
        write(columns_of(block, got, source, asked))
        count += len(block.t)
        spans.append(_of_spans(got))
        progress.at(block.done, count)
    if not count:
        raise DataRefused(source.told.name, None, "no sample", "rows with a number in time and outputs")
    last = stream.apply(np.empty((0, 6)), np.empty(0), last=True)
    spans.append(_of_spans(last))
    left = [
        f"{source.told.damage}: samples until then are here" if source.told.damage else "",
        f"{plural(samples.lost, 'row')} without a number in time or outputs: discarded" if samples.lost else "",
        f"repeated rows discarded: {samples.repeated}" if samples.repeated else "",
    ]
    said = (*filter(None, left), *doubts(calibration.document, datetime.now(UTC)), *last.warnings)
    return Applied(count, found.period, document_of(source, calibration, found, asked, count, spans, said), said)


def _refuse_unlike(source: Source, calibration: Calibration) -> None:
    told, document = source.told, calibration.document
    for what, theirs, ours in (
        ("serial", told.serial, calibration.serial), ("model", told.model, calibration.model)
    ):  # fmt: skip
        if theirs not in {None, UNKNOWN} and ours != UNKNOWN and theirs != ours:
            raise DataRefused(
                told.name, None, f"{what} {theirs}", f"{ours}, as the calibration", "name that unit's own"
            )
    is_of_counts = calibration.output == "counts"
    is_rate = told.output == "rate" or (told.output is None and bool(told.rates_in))
    if is_of_counts and is_rate:
        found = f"rates{f' in {told.rates_in}' if told.rates_in else ''}"
        raise DataRefused(told.name, None, found, "counts, as the calibration", "name the columns of counts")
    if not is_of_counts and told.output in {"increments", "cumulative"}:
        expected = "rates, as the calibration"
        raise DataRefused(told.name, None, f"counts ({told.output})", expected, "use a calibration of counts")
    if not is_of_counts:
        refuse_other_units(told, document)
    model = CalibrationModel.of(document)
    model = model.without(tuple(name for name in model.taken_off if name not in calibration.effects))
    channels = [name.removeprefix(AUXILIARY) for name in told.auxiliary]
    lacks = lacking(model, document, channels, told.triads, has_temperature=told.temperature)
    if lacks:
        sizes = ", ".join(f"{name} ({size or 'of unknown size'})" for name, size in lacks.items())
        remedy = f"name its column, or continue with {' '.join(f'--without {name}' for name in lacks)}"
        raise DataRefused(told.name, None, f"no data for these error terms: {sizes}", "their inputs", remedy)


def _of_spans(got: Calibrated) -> Calibrated:
    """Return the spans alone, so that samples are let go."""
    none = np.empty((0, 3))
    return Calibrated(np.empty(0), none, none, got.spans, got.specific_force_std, got.angular_rate_std)


def _beside(out: Path) -> Path:
    return out.with_name(f"{out.name}.json")
