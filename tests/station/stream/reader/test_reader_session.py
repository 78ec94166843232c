"""What the reader process says of bytes that the station did not collect."""

import pytest

from drivers.device_url_parser import parse_device_url
from station.stream.reader import __main__ as process
from station.stream.reader.messages import Chunk, GapMark, unpacked


class Crowded:
    """An outbox that has room, or has none, as it was told; what it takes is kept."""

    def __init__(self, *has_room: bool) -> None:
        self.has_room, self.taken = list(has_room), bytearray()

    def put(self, message: bytes, *, always: bool = False) -> bool:
        has_room = self.has_room.pop(0)
        self.taken += message if has_room else b""
        return has_room


def test_each_byte_that_was_not_collected_is_told_of_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "open_port", lambda url: None)
    outbox = Crowded(False, False, True, False, True, True, True)
    url = parse_device_url("serial:///dev/ttyUSB0?format=counts")
    session = process._Session(url, None, outbox)  # noqa: SLF001
    for host_ns, size in enumerate((3, 5, 7, 11, 13)):
        session._hand_on(Chunk(host_ns, b"x" * size))  # noqa: SLF001
    assert outbox.has_room == []
    assert list(unpacked(outbox.taken)) == [
        GapMark(2, "8 bytes not collected in time; they are lost", is_open=True),
        GapMark(3, "7 bytes not collected in time; they are lost", is_open=True),
        Chunk(3, b"x" * 11),
        Chunk(4, b"x" * 13),
    ]
