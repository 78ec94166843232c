"""What is named on the command line as a source of samples: by what it is, else by its suffix."""

from dataclasses import replace
from pathlib import Path

from station.applying.campaign_source import CampaignSource
from station.applying.log_source import LogSource
from station.applying.recording_source import RecordingSource
from station.applying.source import Source, Told
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML
from station.files.logs.log_columns import ToldColumns

RECORDING = "recording.mcap"


def open_source(path: Path, columns: ToldColumns, serial: str | None) -> Source:
    """Open a campaign's folder, one that `station record` made, an MCAP file or a log.

    ``columns`` is what was told of a log, ``serial`` the unit's serial number where the recording has none.

    Raises
    ------
    DataRefused
        If it is none of them.
    """
    if path.is_dir():
        if (path / CAMPAIGN_TOML).is_file():
            return CampaignSource.open(path)
        if not (path / RECORDING).is_file():
            expected = f"a folder with {CAMPAIGN_TOML} or {RECORDING}"
            raise DataRefused(path, None, "neither a campaign nor a recording", expected, "name a file of it")
        path /= RECORDING
    if path.suffix.lower() == ".mcap":
        return RecordingSource.open(path, Told(str(path), serial=serial))
    found = LogSource.open(path, columns)
    return replace(found, told=replace(found.told, serial=serial))
