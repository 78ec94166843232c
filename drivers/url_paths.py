"""A device's URL whose files are found from any folder, so that it can be kept and used on another day."""

import os
import re
from urllib.parse import quote, unquote, unquote_plus

from drivers.bare_address import Role, whole_url

NAMES = ("dbc", "map", "key")
_FILE = re.compile(rf"(?<=[?&])({'|'.join(NAMES)})=([^&]+)")
_REPLAY = re.compile(r"^(replay:)([^?]+)")


def anchored(typed: str, role: Role = "imu") -> str:
    """Return an address as a URL with whole paths, those not yet such from the folder that the program runs in."""
    url = whole_url(typed, role)
    found = _FILE.sub(lambda each: f"{each[1]}={quote(os.path.abspath(unquote_plus(each[2])), safe='/')}", url)
    return _REPLAY.sub(lambda each: each[1] + quote(os.path.abspath(unquote(each[2])), safe="/"), found)
