"""An address as people type it, made a URL: ``/dev/ttyUSB0``, ``ttyUSB0``, ``imu.local:5000``, ``can0``, a file.

Such an address says where, not what; what is there follows from who asks: for an IMU, a receiver or a camera.
A bare ``udp:14550`` hears this machine alone: who wants to hear the network names an address of it, or 0.0.0.0.
"""

import os
import re
import stat
from typing import Literal
from urllib.parse import quote, unquote, unquote_plus

Role = Literal["imu", "receiver", "camera"]
_QUERY = r"(?P<query>\?.*)?"
_DEVICE = re.compile(rf"(?P<path>/dev/[^?]+|tty[A-Z]\w*|video\d+){_QUERY}")
_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[\w.-]+):\d{1,5}([/?].*)?", re.ASCII)
_CAN = re.compile(rf"(?P<name>(v|sl)?can\d+){_QUERY}", re.ASCII)
_UDP = re.compile(rf"(?P<way>udp|udpin|udpout):(//)?((?P<host>[^?]+):)?(?P<port>\d{{1,5}}){_QUERY}", re.ASCII)
_SERIAL = re.compile(r"serial:/{0,2}(?P<path>/?[^/].*)")
_TCP = re.compile(r"tcp:/?(?P<where>[^/].*)")
_FILE_OPTION = re.compile(r"(?<=[?&])(dbc|map|key)=([^&]+)")
_REPLAY = re.compile(r"^(replay:)([^?]+)")
_RECORDED = re.compile(r".*(/|\.(mcap|bin|dat|raw|log|csv|txt)$)")


def whole_url(text: str, role: Role = "imu") -> str:
    """Return what was typed as a URL; as it is where it is one, or where nothing can be made of it."""
    typed = text.strip()
    path = typed.partition("?")[0]
    if _is_device(path):
        return _of_device(os.path.abspath(path) + typed[len(path) :], role)
    if found := _DEVICE.fullmatch(typed):
        return _of_device(typed if typed.startswith("/") else f"/dev/{typed}", role)
    if found := _UDP.fullmatch(typed):
        way = found["way"].replace("udp", "udpin") if found["way"] == "udp" else found["way"]
        return f"mavlink:{way}:{found['host'] or '127.0.0.1'}:{found['port']}{found['query'] or ''}"
    if found := _CAN.fullmatch(typed):
        return f"can://socketcan/{found['name']}{found['query'] or ''}"
    if found := _SERIAL.fullmatch(typed):  # nobody remembers how many slashes
        return f"serial://{'' if found['path'].startswith('/') else '/'}{found['path']}"
    if found := _TCP.fullmatch(typed):
        return f"tcp://{found['where']}"
    if _HOST.fullmatch(typed):
        return {"imu": "tcp://", "receiver": "mavlink:tcp:", "camera": "camera:http://"}[role] + typed
    if typed.startswith("http://"):
        return f"camera:{typed}"
    if ":" not in path and (os.path.isfile(path) or _RECORDED.fullmatch(path)):
        return f"replay:{typed}"
    return text


def with_absolute_paths(typed: str, role: Role = "imu") -> str:
    """Return an address as a URL whose files are found from any folder, so that it can be used on another day."""
    url = whole_url(typed, role)
    found = _FILE_OPTION.sub(
        lambda each: f"{each[1]}={quote(os.path.abspath(unquote_plus(each[2])), safe='/')}", url
    )
    return _REPLAY.sub(lambda each: each[1] + quote(os.path.abspath(unquote(each[2])), safe="/"), found)


def _is_device(path: str) -> bool:
    try:
        return ":" not in path and stat.S_ISCHR(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def _of_device(path: str, role: Role) -> str:
    if role == "camera" or path.startswith("/dev/video"):
        return f"camera:{path}"
    return f"mavlink:serial:{path}" if role == "receiver" else f"serial://{path}"
