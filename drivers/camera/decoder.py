"""A camera's bytes to JPEG images and back: multipart/x-mixed-replace, as streamers and network cameras send it.

An image begins where a part's header ends and ends where its markers say (`drivers.camera.jpeg`); a Content-Length
must agree. Of a stream without any header images begin at SOI, and bytes lost within one show only where they
break the markers.
"""

import re
from collections import deque
from dataclasses import dataclass, field

from drivers.camera.jpeg import BEGIN, BrokenJpeg, JpegScanner

MAX_IMAGE_BYTES = 8 * 2**20  # of an image: 4K at a high quality
MAX_HEADER_BYTES = 4096  # the longest header that is looked at
STAMP_BYTES = 64  # bytes that share a stamp where reads are shorter: bounds how many are kept
MIN_BOUNDARY_CHARS = 6  # characters of a boundary that an image does not have by chance
MAX_AGE_S = 60.0  # an age above is none
FIELD = re.compile(rb"([A-Za-z][!-9;-~]{0,63}):[ \t]*([ -~]{0,512})\r?")
BLANK_OR_BEGIN = re.compile(rb"\n\r?\n|\xff\xd8\xff")
SECONDS = re.compile(r"(\d{1,10})(?:\.(\d{1,9}))?")


@dataclass(frozen=True, slots=True)
class CameraImage:
    """An image and when it was taken.

    ``host_ns`` [ns] of the station's clock: when its first byte was read, less the age that the part states
    (``X-Age`` [s]). ``device_ns`` [ns] is the sender's stamp (``X-Timestamp`` [s]), None where there is none.
    ``read_ns`` [ns] is when its last byte was read: before, nobody has it.
    """

    host_ns: int
    device_ns: int | None
    jpeg: bytes
    read_ns: int = field(default=0, compare=False)

    @property
    def came_ns(self) -> int:
        """The moment [ns] from which it is there."""
        return max(self.host_ns, self.read_ns)


@dataclass(slots=True)
class CameraCounters:
    """What came: whole images, bytes in neither image nor header, parts that are no JPEG, images cut or broken."""

    images: int = 0
    skipped_bytes: int = 0
    not_jpeg: int = 0
    cut: int = 0


@dataclass(frozen=True, slots=True)
class _Header:
    length: int | None = None
    device_ns: int | None = None
    age_ns: int = 0


class CameraDecoder:
    """Bytes as they come to images; never raises, and keeps no more than one image's bytes."""

    def __init__(self) -> None:
        self.counters = CameraCounters()
        self._data = bytearray()
        self._now_ns = 0  # of the newest read
        self._fed = 0  # bytes since the beginning, of which those before `_data` are done with
        self._stamps: deque[tuple[int, int]] = deque()  # where reads began, and when they were
        self._header: _Header | None = None  # it ended where `_data` begins
        self._has_headers = False
        self._boundary = b""  # the line before a header
        self._scanner: JpegScanner | None = None  # of the image that begins `_data`

    def feed(self, data: bytes, host_ns: int) -> list[CameraImage]:
        """Return the images whose last byte has come with ``data``, read at ``host_ns`` [ns]."""
        self._now_ns = host_ns
        if not self._data:
            self._stamps.clear()
        if not self._stamps or self._fed - self._stamps[-1][0] >= STAMP_BYTES:
            self._stamps.append((self._fed, host_ns))
        self._data += data
        self._fed += len(data)
        images = list[CameraImage]()
        while self._find_image() if self._scanner is None else self._finish_image(self._scanner, images):
            pass
        return images

    def _find_image(self) -> bool:
        """Go to where an image begins; False if there is none in what has come."""
        if self._header is not None:
            if len(self._data) < len(BEGIN) and BEGIN.startswith(self._data):
                return False
            if self._data.startswith(BEGIN):
                self._scanner = JpegScanner()
            else:
                self._header = None
                self.counters.not_jpeg += 1
            return True
        found = BLANK_OR_BEGIN.search(self._data)
        if found is None:
            self._skip(len(self._data) - MAX_HEADER_BYTES)
            return False
        if found[0] != BEGIN:
            self._read_header(found.end())
        elif self._has_headers:  # such as what is left of an image whose header was damaged
            self._skip(found.start() + 2)
        else:
            self._skip(found.start())
            self._header, self._scanner = _Header(), JpegScanner()
        return True

    def _read_header(self, end: int) -> None:
        """Take the header that a blank line ends at ``end``, if there is one."""
        window = max(0, end - MAX_HEADER_BYTES)
        begin, fields = _fields(bytes(self._data[window:end]))
        junk = window + begin if fields else end
        line = self._data.rfind(b"\n", 0, max(0, junk - 1)) + 1
        if fields and self._data.startswith(b"--", line):  # the boundary, a line of its own
            self._boundary, junk = bytes(self._data[line:junk]).rstrip(), line
        self._skip(junk)
        del self._data[: end - junk]
        if fields:
            self._has_headers = True
            self._header = _header(fields)

    def _finish_image(self, scanner: JpegScanner, images: list[CameraImage]) -> bool:
        """Take the image that begins the data to its end; False if more of it must come first."""
        header = self._header or _Header()
        try:
            end = scanner.end(self._data)
        except BrokenJpeg as broken:
            return self._give_up(broken.at)
        if end is None:
            come = len(self._data)
            is_led_astray = scanner.reached > come and self._next_part(come) is not None
            is_too_long = scanner.reached > (header.length or MAX_IMAGE_BYTES) or come > MAX_IMAGE_BYTES
            return (is_led_astray or is_too_long) and self._give_up(scanner.last)
        if header.length is None and self._next_part(end) is not None:  # a segment led into the next image
            return self._give_up(end)
        if header.length is not None and end != header.length:
            padding = self._data[end : header.length]  # some cameras hand on buffers of even length
            if end > header.length or padding.strip(b"\0\xff"):
                return self._give_up(scanner.last)
            if len(self._data) < header.length:
                return False
        taken_ns, jpeg = self._read_at() - header.age_ns, bytes(self._data[:end])
        images.append(CameraImage(taken_ns, header.device_ns, jpeg, self._now_ns))
        self.counters.images += 1
        del self._data[: header.length or end]
        self._header = self._scanner = None
        return True

    def _give_up(self, at: int) -> bool:
        """Look for the next image after the last marker that was one, or where another part begins before it."""
        self.counters.cut += 1
        self._header = self._scanner = None
        other = self._next_part(at)
        self._skip(at + 2 if other is None else other)
        return True

    def _next_part(self, end: int) -> int | None:
        """Return where a boundary stands before ``end``, if one does."""
        if len(self._boundary) < MIN_BOUNDARY_CHARS:
            return None
        at = self._data.find(self._boundary, 0, end)
        return None if at < 0 else at

    def _skip(self, length: int) -> None:
        """Let go of bytes that are of no image; line ends are not counted."""
        if length > 0:
            junk = self._data[:length]
            self.counters.skipped_bytes += length - junk.count(b"\r") - junk.count(b"\n")
            del self._data[:length]

    def _read_at(self) -> int:
        """Return when the first byte held was read [ns]."""
        at = self._fed - len(self._data)
        while len(self._stamps) > 1 and self._stamps[1][0] <= at:
            self._stamps.popleft()
        return self._stamps[0][1]


def _fields(text: bytes) -> tuple[int, dict[bytes, bytes]]:
    """Return the header that ends a text with its blank line, by names in small letters, and where it begins."""
    lines = text.split(b"\n")
    begin, fields = len(text) - len(lines[-2]) - 1, dict[bytes, bytes]()
    for line in reversed(lines[:-2]):
        found = FIELD.fullmatch(line)
        if found is None:
            break
        begin -= len(line) + 1
        fields.setdefault(found[1].lower(), found[2].strip())  # what stands nearest to the image counts
    return begin, fields


def _header(fields: dict[bytes, bytes]) -> _Header:
    length = fields.get(b"content-length", b"")
    age = _nanoseconds(fields.get(b"x-age", b""))
    return _Header(
        int(length) if length.isdigit() and len(length) < 9 and 0 < int(length) <= MAX_IMAGE_BYTES else None,
        _nanoseconds(fields.get(b"x-timestamp", b"")),
        age if age is not None and age <= MAX_AGE_S * 1e9 else 0,
    )


def _nanoseconds(text: bytes) -> int | None:
    found = SECONDS.fullmatch(text.decode("ascii"))
    return None if found is None else int(found[1]) * 10**9 + int((found[2] or "").ljust(9, "0"))


BOUNDARY = "boundarydonotcross"
CONTENT_TYPE = f"multipart/x-mixed-replace; boundary={BOUNDARY}"


def part(jpeg: bytes, stamp_s: float | None = None, age_s: float | None = None) -> bytes:
    """Return an image as a part; ``stamp_s`` is the sender's clock when it was taken, ``age_s`` how old it is."""
    fields = ["Content-Type: image/jpeg", f"Content-Length: {len(jpeg)}"]
    if stamp_s is not None:
        fields.append(f"X-Timestamp: {stamp_s:.6f}")
    if age_s is not None:
        fields.append(f"X-Age: {age_s:.6f}")
    return b"\r\n".join([b"--" + BOUNDARY.encode(), *(field.encode() for field in fields), b"", jpeg, b""])
