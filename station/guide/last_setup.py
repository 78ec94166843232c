"""The last set-up, kept in the user's configuration."""

import os
from pathlib import Path

import platformdirs
from pydantic import ValidationError

from drivers.addresses import with_absolute_paths
from station.errors import cannot_write
from station.files.atomic_file import replace_file
from station.files.campaign_setup import Setup


def setup_file() -> Path:
    """Return where the last set-up is kept: the user's configuration, or the folder ``STATION_CONFIG`` names."""
    folder = os.environ.get("STATION_CONFIG")
    return (Path(folder) if folder else platformdirs.user_config_path("fog-station")) / "setup.json"


def load_setup() -> Setup:
    """Return the last set-up; the default one where there is none or it cannot be read."""
    try:
        return Setup.model_validate_json(setup_file().read_bytes())
    except (OSError, ValidationError):
        return Setup()


def from_anywhere(setup: Setup) -> Setup:
    """Return a set-up whose addresses mean the same in any folder."""
    gnss = with_absolute_paths(setup.gnss, "receiver")
    return setup.model_copy(update={"url": with_absolute_paths(setup.url), "gnss": gnss})


def save_setup(setup: Setup) -> None:
    """Remember a set-up; raise `CannotWrite` if the place cannot be written."""
    path = setup_file()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path.parent, error) from error
    replace_file(path, (from_anywhere(setup).model_dump_json(indent=1) + "\n").encode())
