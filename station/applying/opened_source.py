"""What is named on the command line as a source of samples: by what it is, else by its suffix."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from procedures.error_codes import ErrorCode
from station.applying.campaign_source import CampaignSource
from station.applying.log_source import LogSource
from station.applying.raw_source import RawSource
from station.applying.recording_source import RecordingSource
from station.applying.source import Source, Told
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML
from station.files.logs.log_columns import ToldColumns
from station.files.mcap_files.reader import sample_messages, topic_messages
from station.files.mcap_files.schemas import RAW_TOPIC

RECORDING = "recording.mcap"
KEPT = "session_*.mcap"  # of `station stream --folder`


def open_source(path: Path, columns: ToldColumns, serial: str | None) -> Source:
    """Open a campaign's folder, one of `station record` or `station stream`, an MCAP file or a log.

    ``columns`` is what was told of a log, ``serial`` the unit's serial number where the recording has none.

    Raises
    ------
    DataRefused
        If it is none of them.
    """
    if path.is_dir():
        if (path / CAMPAIGN_TOML).is_file():
            return CampaignSource.open(path)
        path = _recording_in(path)
    if path.suffix.lower() == ".mcap":
        told = Told(str(path), serial=serial)
        return RawSource.open(path, told) if _is_of_bytes(path) else RecordingSource.open(path, told)
    found = LogSource.open(path, columns)
    return replace(found, told=replace(found.told, serial=serial))


def _recording_in(folder: Path) -> Path:
    """Return the recording in a folder, or the bytes that `station stream` kept in it."""
    if (folder / RECORDING).is_file():
        return folder / RECORDING
    kept = sorted(folder.glob(KEPT))
    if len(kept) != 1:
        found = f"{len(kept)} files {KEPT}" if kept else "neither a campaign nor a recording"
        expected = f"a folder with {CAMPAIGN_TOML}, {RECORDING} or one {KEPT}"
        raise DataRefused(folder, None, found, expected, "name a file of it")
    return kept[0]


def _is_of_bytes(file: Path) -> bool:
    """Say whether an MCAP file holds bytes of a device and no samples."""
    try:
        with closing(sample_messages(file)) as samples, closing(topic_messages(file, {RAW_TOPIC: bytes})) as raw:
            return next(samples, None) is None and next(raw, None) is not None
    except OSError as error:
        raise DataRefused(
            file, None, (error.strerror or str(error)).lower(), "a readable file", code=ErrorCode.FILE_MISSING
        ) from None
