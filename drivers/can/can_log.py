"""Logs of a CAN bus as other programs write them, as the records of `drivers.can.frame_record`.

candump's two forms, Vector's ASC and BLF, PEAK's TRC, python-can's CSV, each by python-can's reader and known by
how the file begins. The time of the log becomes the records' host time.
"""

import re
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from io import StringIO
from itertools import islice, product

import can
import numpy as np
from can.io import ASCReader, BLFReader, CanutilsLogReader, CSVReader, TRCReader

from drivers.addresses import ReplayAddress
from drivers.can.frame_record import ERROR, EXTENDED, REMOTE, WIDE, SenderWatch, pack
from drivers.can.mapping_file import CanMap, load_map
from drivers.errors import BadCanFile, reason_of
from drivers.port_interface import ReplayPort
from drivers.text_decoding import decoded_text

FIRST_LINES = 20
HEAD_BYTES = 4096  # in which a log shows what it is
IN_MEMORY = 2**26  # bytes of records; more go to a temporary file
LINES_AT_ONCE = 20_000
NO_FRAME = bytes(32)  # in the place of a damaged line
MAX_BAD_SHARE = 0.01  # of lines that are no frame: cut or run together where bytes were lost
_CANDUMP_L = re.compile(
    r"\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#(?:#[0-9A-Fa-f]|R\d?)?(?:[0-9A-Fa-f]{2})*(?:\s+[RT])?"
)
_CANDUMP = re.compile(
    r"\((?P<time>\d+\.\d+)\)\s+(?P<channel>\S+)\s+(?P<id>[0-9A-Fa-f]{3,8})\s+\[(?P<size>\d+)\]\s*"
    r"(?P<data>(?:[0-9A-Fa-f]{2}(?:\s+|$))*)(?P<remote>remote request)?(?:\s*'.*')?"
)
_NO_TIME = re.compile(r"\w+\s+[0-9A-Fa-f]{3,8}\s+\[\d+\].*")


@dataclass(frozen=True, slots=True)
class LogForm:
    """A form of log: what it is called, whether a file that begins so is one, and what reads its frames."""

    name: str
    begins: Callable[[bytes], bool]
    frames: Callable[[str], Iterable[can.Message | None]]  # None: a line that is no frame


def _has_lines(head: bytes, form: re.Pattern[str]) -> bool:
    """Say whether half of the first lines, but the last, which may be cut, are of a form."""
    lines = [line.strip("\ufeff\0 \t") for line in decoded_text(head).splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")][:FIRST_LINES]
    return 2 * sum(bool(form.fullmatch(line)) for line in lines) > max(len(lines) - 1, 1)


def _candump(path: str) -> Iterator[can.Message | None]:
    """Yield the frames of candump's text, None for a line that is none, up to `MAX_BAD_SHARE` of them."""
    lines = bad = number = first_bad = 0
    with open(path, encoding="utf-8", errors="replace") as file:
        while part := list(islice(file, LINES_AT_ONCE)):
            good = list[str]()
            for line in part:
                number += 1
                if not (text := line.strip("\ufeff\0 \t\r\n")) or text.startswith("#"):
                    continue
                lines += 1
                if (plain := _as_log_line(text)) is not None:
                    good.append(plain)
                else:
                    bad, first_bad = bad + 1, first_bad or number
                    yield from CanutilsLogReader(StringIO("\n".join(good)))
                    yield None
                    good.clear()
            yield from CanutilsLogReader(StringIO("\n".join(good)))
    if bad > max(1, MAX_BAD_SHARE * lines):
        found = f"{bad} of {lines} lines that are no frame"
        raise BadCanFile(path, first_bad, found, "lines of candump; repair the log or record it again")


def _asc(path: str) -> Iterator[can.Message]:
    """Yield the frames of an ASC; raise `BadCanFile` where its times are steps, which the reader ignores."""
    with open(path, encoding="utf-8", errors="replace") as file:
        reader = ASCReader(file)
        for message in reader:
            if reader.timestamps_format == "relative":
                raise BadCanFile(path, None, "timestamps relative", "timestamps absolute; export the log again so")
            yield message


def _blf(path: str) -> Iterator[can.Message]:
    with open(path, "rb") as file:
        yield from BLFReader(file)


def _text(reader: type[TRCReader | CSVReader], path: str) -> Iterator[can.Message]:
    with open(path, encoding="utf-8", errors="replace") as file:
        yield from reader(file)


def _as_log_line(text: str) -> str | None:
    """Return a line of candump as ``candump -L`` writes it, None where it is no frame."""
    if _CANDUMP_L.fullmatch(text):
        return text
    if (found := _CANDUMP.fullmatch(text)) is None:
        return None
    data = "".join(found["data"].split())
    if not found["remote"] and len(data) != 2 * int(found["size"]):
        return None
    return f"({found['time']}) {found['channel']} {found['id']}#{'R' if found['remote'] else data}"


FORMS = (
    LogForm("candump", lambda head: _has_lines(head, _CANDUMP_L) or _has_lines(head, _CANDUMP), _candump),
    LogForm("Vector BLF", lambda head: head.startswith(b"LOGG"), _blf),
    LogForm("Vector ASC", lambda head: bool(re.search(rb"(?im)^\s*base\s+(?:hex|dec)\b", head)), _asc),
    LogForm("PEAK TRC", lambda head: b";$FILEVERSION" in head or b";   Start time:" in head,
            partial(_text, TRCReader)),
    LogForm("python-can CSV", lambda head: head.startswith(b"timestamp,arbitration_id,"),
            partial(_text, CSVReader)),
)  # fmt: skip


def form_of(path: str) -> LogForm | None:
    """Return which form of log a file is, None where it is none of them or cannot be read.

    Raises `BadCanFile` if it is candump's text without times: nothing says when its frames came.
    """
    try:
        with open(path, "rb") as file:
            head = file.read(HEAD_BYTES)
    except OSError:
        return None
    if _has_lines(head, _NO_TIME):
        raise BadCanFile(path, 1, "candump's text without times", "a log with them; record with candump -L")
    return next((form for form in FORMS if form.begins(head)), None)


def open_can_log(address: ReplayAddress, form: LogForm) -> ReplayPort:
    """Open a log of one of `FORMS`; it is read whole first, so that what is wrong is known.

    Raises `BadCanFile` if the address names no DBC, the log is damaged, or the frames wanted come on several
    channels or from several devices and the address does not say which.
    """
    path = address.path
    if not (address.dbc and address.map):
        expected = "dbc and map in its address: replay:FILE?dbc=FILE&map=FILE (docs/how-to/can.md)"
        raise BadCanFile(path, None, f"a CAN log ({form.name})", expected)
    wanted = address.channel
    can_map, seen = load_map(address.dbc, address.map), Counter[tuple[str, int]]()
    records = tempfile.SpooledTemporaryFile(IN_MEMORY)
    try:
        for message in form.frames(path):
            if message is None:  # counted with what the recording says of bytes in no frame
                records.write(NO_FRAME)
                continue
            channel = "" if message.channel is None else str(message.channel)
            identifier = message.arbitration_id | EXTENDED * message.is_extended_id
            identifier |= REMOTE * message.is_remote_frame | ERROR * message.is_error_frame
            seen[channel, identifier] += 1
            if wanted in {None, channel}:
                records.write(pack(identifier, round(message.timestamp * 1e9), bytes(message.data or b"")))
        _refuse_unclear(seen, can_map, path, wanted)
    except BadCanFile:
        records.close()
        raise
    except Exception as error:  # the edge to a library whose readers raise what they like on damaged files
        records.close()
        raise BadCanFile(path, None, f"a damaged {form.name} log ({reason_of(error)})", "a whole one") from error
    records.seek(0)
    return ReplayPort(records, path)


def _refuse_unclear(seen: Counter[tuple[str, int]], can_map: CanMap, path: str, wanted: str | None) -> None:
    """Raise `BadCanFile` unless each message of a sample came, all on one channel and from one device.

    ``seen`` counts frames by channel and identifier.
    """
    ours = {key: n for key, n in seen.items() if any(slot.is_of(key[1]) for slot in can_map.slots)}
    channels = Counter[str]()
    for (channel, _), n in ours.items():
        channels[channel] += n
    if wanted is not None and wanted not in channels:
        named = ", ".join(sorted({channel for channel, _ in seen})) or "none"
        raise BadCanFile(path, None, f"no frames of {can_map.name} on channel {wanted!r}", f"one of {named}")
    if wanted is None and len(channels) > 1:
        each = ", ".join(f"{name} ({n} frames)" for name, n in sorted(channels.items()))
        say = " or ".join(f"channel={name}" for name in sorted(channels))
        found = f"frames of {can_map.name} on channels {each}"
        raise BadCanFile(path, None, found, f"one; say {say} in its address")
    for slot in can_map.slots[: can_map.needed]:
        if not any(slot.is_of(identifier) for _, identifier in ours):
            found = f"{seen.total()} frames and none of {slot.name} (0x{slot.identifier & WIDE:X})"
            expected = "every message of a sample; check the DBC, or leave its sensor out of the mapping file"
            raise BadCanFile(path, None, found, expected)
    watch = SenderWatch(can_map.path)
    for (channel, identifier), slot in product(ours, can_map.slots):
        if slot.sender is not None and slot.is_of(identifier) and wanted in {None, channel}:
            watch.look(slot.sender, np.array([identifier], np.uint32))
