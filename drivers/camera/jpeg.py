"""Where a JPEG ends and how large its image is, by its markers alone (ITU-T T.81, annex B); nothing is decoded.

Segments have their length in them, so that an image within one (EXIF's thumbnail) is passed over. In a scan 0xFF
is data only before 0x00 or as a restart marker; any other marker ends the scan.
"""

import re

SOI, SOS = 0xD8, 0xDA
BEGIN, END = b"\xff\xd8\xff", b"\xff\xd9"
FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # SOF0 to SOF15; the three others are DHT, JPG, DAC
FIRST_MARKER = 0xC0  # markers below are reserved
RESTARTS = range(0xD0, SOI)
MARKER = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")


class BrokenJpeg(ValueError):
    """What is no JPEG from here on; ``at`` is the last marker up to which it may have been one."""

    def __init__(self, at: int) -> None:
        self.at = at
        super().__init__(f"no marker after the one at {at}")


class JpegScanner:
    """Looks for the end of a JPEG that comes in pieces; every byte is looked at once."""

    def __init__(self) -> None:
        self.reached = 2  # what is known to be of the image; may lie beyond the bytes that have come
        self.last = 0  # where the last whole marker stands
        self.size: tuple[int, int] | None = None
        self._is_scan = self._had_scan = False

    def end(self, data: bytes | bytearray) -> int | None:
        """Return where the image that begins ``data`` ends, None if it goes on; raise `BrokenJpeg`."""
        while True:
            if self._is_scan and not self._leave_scan(data):
                return None
            at = self.reached
            if data.startswith(END, at):
                if self.size is None or not self._had_scan:
                    raise BrokenJpeg(self.last)
                return at + 2
            if len(data) < at + 4:
                return None
            if data[at] == data[at + 1] == 0xFF:  # any marker may have fill bytes before it
                self.reached += 1
            elif not self._segment(data, at):
                return None

    def _leave_scan(self, data: bytes | bytearray) -> bool:
        found = MARKER.search(data, self.reached)
        if found is None:
            self.reached = max(self.reached, len(data) - 1)
            return False
        self.reached, self._is_scan = found.start(), False
        return True

    def _segment(self, data: bytes | bytearray, at: int) -> bool:
        """Pass a segment; False if more of it is needed."""
        code, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if data[at] != 0xFF or code < FIRST_MARKER or code == SOI or code in RESTARTS or length < 2:
            raise BrokenJpeg(self.last)
        if code in FRAMES:
            if len(data) < at + 9:
                return False
            height, width = (int.from_bytes(data[at + i : at + i + 2], "big") for i in (5, 7))
            self.size = width, height
        self.last, self.reached, self._is_scan = at, at + 2 + length, code == SOS
        self._had_scan |= self._is_scan
        return True


def jpeg_size(jpeg: bytes) -> tuple[int, int]:
    """Return width and height [px]; raise `BrokenJpeg` where that is no whole JPEG."""
    scanner = JpegScanner()
    if scanner.end(jpeg) is None or scanner.size is None:
        raise BrokenJpeg(len(jpeg))
    return scanner.size
