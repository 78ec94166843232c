"""Calibrated samples as files: a writer each format, a line each in `WRITERS`."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from station.errors import DataRefused
from station.files.sample_files.csv_samples import CsvSamples
from station.files.sample_files.mat_samples import MatSamples
from station.files.sample_files.mcap_samples import McapSamples
from station.files.sample_files.npz_samples import NpzSamples
from station.files.sample_files.parquet_samples import ParquetSamples
from station.files.sample_files.ros2_samples import Ros2Samples
from station.files.sample_files.sample_file import SampleColumns, SampleWriter

WRITERS: Mapping[str, Callable[[Path, SampleColumns], SampleWriter]] = MappingProxyType({
    ".csv": CsvSamples,
    ".parquet": ParquetSamples,
    ".mcap": McapSamples,
    ".npz": NpzSamples,
    ".mat": MatSamples,
    ".ros2": Ros2Samples,
})  # fmt: skip
"""By the suffix of what is asked for."""


def writer_for(path: Path) -> Callable[[Path, SampleColumns], SampleWriter]:
    """Return what writes a file of this suffix; raise `DataRefused` where nothing does."""
    if (writer := WRITERS.get(path.suffix.lower())) is None:
        found = f"suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise DataRefused(path, None, found, f"one of {', '.join(WRITERS)}", "name the file so")
    return writer
