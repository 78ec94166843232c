"""A stream of bytes to checked MAVLink 1 and 2 frames: survives any cut, noise and false start.

As `drivers.framing`: from a start byte on, the bytes are a frame if its message is known and its CRC agrees; if
not, the search goes on one byte later. With a key, what is unsigned, wrongly signed or old is refused.
"""

import re
from dataclasses import dataclass

from drivers.mavlink.messages import CRC_EXTRA, Frame, crc
from drivers.mavlink.signing import SIGNATURE_BYTES, SIGNED, SignatureCheck

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
        return self._scan(self._pending + data, at_end=False)

    def finish(self) -> list[Frame]:
        """Return what the bytes still waiting hold when no more will come."""
        return self._scan(self._pending, at_end=True)

    def _scan(self, buffer: bytes, *, at_end: bool) -> list[Frame]:
        found, total = list[Frame](), len(buffer)
        at = kept = 0
        while (start := _START.search(buffer, at)) is not None:
            at = start.start()
            end = self._end(buffer, at)
            if end > total and not at_end:
                break
            if at < end <= total and (frame := self._frame(buffer[at:end])) is not None:
                if self._is_wanted(buffer[at:end], frame):
                    found.append(frame)
                kept += end - at
                at = end
            else:
                at += 1
        else:
            at = total
        self.counters.skipped_bytes += at - kept
        self._pending = buffer[at:]
        return found

    def _end(self, buffer: bytes, at: int) -> int:
        """Return where a frame that begins at ``at`` would end; ``at`` if none can."""
        head = buffer[at : at + _HEAD_V2]
        if head[0] != _V2:
            if len(head) < _HEAD_V1:
                return at + _HEAD_V1
            size, number = _HEAD_V1, head[5]
        else:
            if len(head) < _HEAD_V2:
                return at + _HEAD_V2
            size, number = _HEAD_V2, head[7] | head[8] << 8 | head[9] << 16
            if head[2] & ~SIGNED:
                self.counters.unknown += 1
                return at
            size += SIGNATURE_BYTES * (head[2] & SIGNED)
        if number not in CRC_EXTRA:
            self.counters.unknown += 1
            return at
        return at + size + head[1] + 2

    def _frame(self, raw: bytes) -> Frame | None:
        if raw[0] == _V2:
            number, begin = raw[7] | raw[8] << 8 | raw[9] << 16, _HEAD_V2
            sequence, system, component = raw[4], raw[5], raw[6]
        else:
            number, begin = raw[5], _HEAD_V1
            sequence, system, component = raw[2], raw[3], raw[4]
        end = begin + raw[1]
        if crc(raw[1:end], CRC_EXTRA[number]) != raw[end] | raw[end + 1] << 8:
            self.counters.bad_crc += 1
            return None
        return Frame(number, system, component, sequence, raw[begin:end])

    def _is_wanted(self, raw: bytes, frame: Frame) -> bool:
        if self._signatures is not None:
            judgement = self._signatures.judge(raw, frame.system, frame.component)
            if judgement != "good":
                setattr(self.counters, judgement, getattr(self.counters, judgement) + 1)
                return False
        if self._last.get((frame.system, frame.component)) == raw:  # a router may send it twice
            self.counters.repeated += 1
            return False
        self.counters.frames += 1
        self._follow(frame, raw)
        return True

    def _follow(self, frame: Frame, raw: bytes) -> None:
        """Count what a sender's sequence says is missing."""
        sender = frame.system, frame.component
        last = self._last.get(sender)
        self._last[sender] = raw
        if last is not None:
            step = (frame.sequence - last[4 if last[0] == _V2 else 2]) % 256
            if 0 < step < 128:
                self.counters.lost += step - 1
            else:
                self.counters.disordered += 1
