"""MAVLink's messages, and a stream of bytes to checked frames of MAVLink 1 and 2, found as by `drivers.framing`.

Messages are unpacked by pymavlink's tables (mavlink/mavlink message_definitions, dialect ``all``). Nothing else of
pymavlink reads bytes: its parser loses the frame after a false start, takes a message that it does not know
without a check, and moves a stream's time before it has checked the signature.

MAVLink 2 signing (mavlink.io/en/guide/message_signing.html): a frame's signature is the first 48 bits of SHA-256
over key and frame. Its time stamp [10 us since 2015] must grow within a stream (link, system, component); the
first may be a minute behind.
"""

import hashlib
import hmac
import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pymavlink.dialects.v20 import all as dialect  # none has more messages
from pymavlink.generator import mavcrc

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


HEARTBEAT, SYSTEM_TIME, GPS_RAW_INT, GLOBAL_POSITION_INT, REQUEST_DATA_STREAM = 0, 2, 24, 33, 66
VFR_HUD, COMMAND_LONG, COMMAND_ACK, HIGHRES_IMU, GPS2_RAW, GPS_INPUT = 74, 76, 77, 105, 124, 232

READ = frozenset(
    (
        HEARTBEAT, SYSTEM_TIME, GPS_RAW_INT, GLOBAL_POSITION_INT, VFR_HUD, COMMAND_ACK, HIGHRES_IMU, GPS2_RAW,
        GPS_INPUT,
    )
)  # fmt: skip
KINDS: dict[int, Any] = dialect.mavlink_map
CRC_EXTRA: dict[int, int] = {number: kind.crc_extra for number, kind in KINDS.items()}
_BYTE = [bytes((value,)) for value in range(256)]
NAMES: dict[int, str] = {number: str(kind.msgname) for number, kind in KINDS.items()}


class Frame(NamedTuple):
    """A checked frame: its message's number, who sent it, its place in the sender's sequence, its payload."""

    number: int
    system: int
    component: int
    sequence: int
    payload: bytes


def fields(frame: Frame) -> dict[str, Any]:
    """Return a frame's fields as on the wire; zeros that MAVLink 2 cut off the end are put back."""
    kind = KINDS[frame.number]
    size = kind.unpacker.size
    values = kind.unpacker.unpack(frame.payload[:size].ljust(size, b"\0"))
    return dict(zip(kind.ordered_fieldnames, values, strict=False))


def crc(body: bytes, extra: int) -> int:
    """Return the CRC-16/MCRF4XX of a frame from its length on, with the message's extra byte."""
    whole = body + _BYTE[extra]
    return int(mavcrc.mcrf4xx(whole)) if mavcrc.mcrf4xx else int(mavcrc.x25crc(whole).crc)


_START = re.compile(rb"[\xfd\xfe]")
_V2 = 0xFD
_HEAD_V1, _HEAD_V2 = 6, 10


@dataclass(slots=True)
class MavlinkCounters:
    """What was met since the framer was made.

    ``frames`` accepted; ``skipped_bytes`` in none; ``bad_crc`` whose check failed; ``unknown`` starts with a
    message number or flag that no dialect has; ``lost`` by the senders' sequences; ``repeated`` the same frame
    again, dropped; ``disordered`` numbers that stood still or went back. With a key, all refused: ``unsigned``,
    ``bad_signature``, ``replayed``.
    """

    frames: int = 0
    skipped_bytes: int = 0
    bad_crc: int = 0
    unknown: int = 0
    lost: int = 0
    repeated: int = 0
    disordered: int = 0
    unsigned: int = 0
    bad_signature: int = 0
    replayed: int = 0

    @property
    def refused(self) -> int:
        """Frames that the signature kept out."""
        return self.unsigned + self.bad_signature + self.replayed


class MavlinkFramer:
    """Takes frames out of one link's bytes, as they come."""

    def __init__(self, signatures: SignatureCheck | None = None) -> None:
        self.counters = MavlinkCounters()
        self._signatures = signatures
        self._pending = b""
        self._last: dict[tuple[int, int], bytes] = {}

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames that ``data`` completes, possibly none."""
        buffer, found = self._pending + data, list[Frame]()
        at = kept = 0
        while (start := _START.search(buffer, at)) is not None:
            at = start.start()
            end, frame = self._read(buffer, at)
            if end > len(buffer):
                break
            if frame is None:
                at += 1
                continue
            if self._is_wanted(buffer[at:end], frame):
                found.append(frame)
            kept += end - at
            at = end
        else:
            at = len(buffer)
        self.counters.skipped_bytes += at - kept
        self._pending = buffer[at:]
        return found

    def _read(self, buffer: bytes, at: int) -> tuple[int, Frame | None]:
        """Return where a frame that begins at ``at`` ends, beyond the buffer if more must come, and the frame."""
        is_v2 = buffer[at] == _V2
        begin = at + (_HEAD_V2 if is_v2 else _HEAD_V1)
        tail = 2  # bytes behind the payload: CRC, signature
        if begin > len(buffer):
            return begin, None
        if is_v2:
            length, flags, _, sequence, system, component = buffer[at + 1 : at + 7]
            number = int.from_bytes(buffer[at + 7 : begin], "little")
            tail += SIGNATURE_BYTES * (flags & SIGNED)
        else:
            length, sequence, system, component, number = buffer[at + 1 : begin]
            flags = 0
        if number not in CRC_EXTRA or flags & ~SIGNED:
            self.counters.unknown += 1
            return at, None
        end = begin + length
        if end + tail > len(buffer):
            return end + tail, None
        if crc(buffer[at + 1 : end], CRC_EXTRA[number]) != buffer[end] | buffer[end + 1] << 8:
            self.counters.bad_crc += 1
            return at, None
        return end + tail, Frame(number, system, component, sequence, buffer[begin:end])

    def _is_wanted(self, raw: bytes, frame: Frame) -> bool:
        """Judge and count a frame, and what its sender's sequence says is missing before it."""
        sender = frame.system, frame.component
        if self._signatures is not None:
            judgement = self._signatures.judge(raw, *sender)
            if judgement != "good":
                setattr(self.counters, judgement, getattr(self.counters, judgement) + 1)
                return False
        last = self._last.get(sender)
        if last == raw:  # a router may send it twice
            self.counters.repeated += 1
            return False
        self.counters.frames += 1
        self._last[sender] = raw
        if last is not None:
            step = (frame.sequence - last[4 if last[0] == _V2 else 2]) % 256
            if 0 < step < 128:
                self.counters.lost += step - 1
            else:
                self.counters.disordered += 1
        return True
