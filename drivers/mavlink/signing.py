"""MAVLink 2 signing of what comes in (mavlink.io/en/guide/message_signing.html).

A frame's signature is the first 48 bits of SHA-256 over key and frame. Its time stamp [10 us since 2015] must grow
within a stream (link, system, component); the first of a stream may be a minute behind. Unlike pymavlink 2.4.50, a
stream's time is only moved by a frame whose signature holds: else one forged frame silences the true sender.
"""

import hashlib
import hmac
import time
from pathlib import Path
from typing import Literal

from drivers.errors import BadDeviceUrl

SIGNED = 0x01  # incompatibility flag
SIGNATURE_BYTES = 13  # bytes: link, 6 of time, 6 of signature
EPOCH_2015 = 1_420_070_400  # s since 1970
TICKS_HZ = 100_000  # per s
MAX_AGE_TICKS = 60 * TICKS_HZ
KEY_BYTES = 32

Judgement = Literal["good", "unsigned", "bad_signature", "replayed"]


class SignatureCheck:
    """Judges frames with one secret key (32 bytes); ``now`` [ticks] is the least time of a new stream's start."""

    def __init__(self, key: bytes, now: int | None = None) -> None:
        self._key = key
        self._now = signing_time() if now is None else now
        self._streams: dict[tuple[int, int, int], int] = {}

    def judge(self, frame: bytes, system: int, component: int) -> Judgement:
        """Judge a whole frame whose CRC is good."""
        if not frame[2] & SIGNED or frame[0] != 0xFD:
            return "unsigned"
        if not hmac.compare_digest(hashlib.sha256(self._key + frame[:-6]).digest()[:6], frame[-6:]):
            return "bad_signature"
        stamp = int.from_bytes(frame[-12:-6], "little")
        stream = frame[-13], system, component
        last = self._streams.get(stream)
        if stamp < self._now - MAX_AGE_TICKS if last is None else stamp <= last:
            return "replayed"
        self._streams[stream] = stamp
        self._now = max(self._now, stamp)
        return "good"


def signing_time() -> int:
    """Return the time of day in a signature's ticks."""
    return int((time.time() - EPOCH_2015) * TICKS_HZ)


def read_key(path: str) -> bytes:
    """Return the key in a file: 32 bytes, or 64 hexadecimal digits; raise `BadDeviceUrl` for anything else."""
    expected = f"a file of {KEY_BYTES} bytes or {2 * KEY_BYTES} hexadecimal digits"
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise BadDeviceUrl(f"key={path}", error.strerror or str(error), expected) from error
    if len(content) == KEY_BYTES:
        return content
    try:
        key = bytes.fromhex(content.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise BadDeviceUrl(f"key={path}", f"{len(content)} bytes that are no key", expected)
    return key
