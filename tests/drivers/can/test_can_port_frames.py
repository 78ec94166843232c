"""A CAN port on a bus that gives the frames of a list: how each is recorded, and what ends the link."""

import errno
from typing import Any

import can
import pytest
from can.interfaces import BACKENDS

from drivers.can import can_port, frame_record
from drivers.can.can_port import CanPort, open_can
from drivers.can.frame_record import ERROR, EXTENDED, REMOTE
from drivers.errors import BadDeviceUrl, LinkLost, PortBusy, PortDenied, PortNotFound

SIZE = frame_record.RECORD.itemsize
OPTIONS = "one of bitrate, name, listens"
OPENED = list[dict[str, Any]]()


class Given(can.BusABC):
    """Gives one after another; raises those that are errors."""

    def __init__(self, channel: str = "x", *given: can.Message | Exception, **options: Any) -> None:
        super().__init__(channel=channel)
        self.given, self.ails, self.waited = list(given), can.BusState.ACTIVE, list[float | None]()

    @property
    def state(self) -> can.BusState:
        return self.ails

    @state.setter
    def state(self, new: can.BusState) -> None:
        self.ails = new

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        self.waited.append(timeout)
        one = self.given.pop(0) if self.given else None
        if isinstance(one, Exception):
            raise one
        return one, False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise NotImplementedError


class Opened(Given):
    """Stands for one of python-can's interfaces, with options of its own."""

    def __init__(
        self, channel: str, bitrate: int = 0, name: str = "", listens: bool = False, **kwargs: Any
    ) -> None:
        super().__init__(channel)
        OPENED.append({"channel": channel, "bitrate": bitrate, "name": name, "listens": listens})
        if isinstance(error := FAILS.get(channel), Exception):
            raise error


def caused(cause: Exception, *, is_context: bool = False) -> Exception:
    error = can.CanInitializationError("no")
    if is_context:
        error.__context__ = cause
    else:
        error.__cause__ = cause
    return error


FAILS: dict[str, Exception] = {
    "denied": PermissionError(errno.EACCES, "no"),
    "forbidden": OSError(errno.EPERM, "no"),
    "busy": OSError(errno.EBUSY, "no"),
    "again": OSError(errno.EAGAIN, "no"),
    "absent": OSError(errno.ENODEV, "nothing there"),
    "cause": caused(OSError(errno.EBUSY, "no")),
    "context": caused(OSError(errno.EACCES, "no"), is_context=True),
    "/dev/busy": OSError(errno.EBUSY, "no"),
    "odd": KeyError("strange"),
}


@pytest.fixture(autouse=True)
def interfaces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BACKENDS, "vector", (__name__, "Opened"))
    monkeypatch.setitem(BACKENDS, "pcan", ("there_is_no_such_module", "Bus"))
    OPENED.clear()


def plain(identifier: int, data: bytes = b"", **flags: Any) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, check=False, **{"is_extended_id": False, **flags})


def read(*given: can.Message | Exception, most: int = 65536) -> list[tuple[int, bytes]]:
    return frame_record.unpack(CanPort(Given("x", *given), "x", 0.0).read(most))


@pytest.mark.parametrize(
    ("message", "identifier", "data"),
    [
        (plain(0, b"\x01"), 0, b"\x01"),
        (plain(0x7FF, b"12345678"), 0x7FF, b"12345678"),
        (plain(0x7FF, is_extended_id=True), EXTENDED | 0x7FF, b""),
        (plain(0x1FFFFFFF, b"ab", is_extended_id=True), EXTENDED | 0x1FFFFFFF, b"ab"),
        (plain(0x123, is_remote_frame=True), REMOTE | 0x123, b""),
        (plain(0x20, bytes(8), is_error_frame=True), ERROR | 0x20, bytes(8)),
        (plain(0x80, bytes(8), is_error_frame=True), ERROR | 0x80, bytes(8)),
        (plain(0x40, b"\x09"), 0x40, b"\x09"),
    ],
)
def test_a_frame_is_recorded_with_its_identifier_flags_and_data(
    message: can.Message, identifier: int, data: bytes
) -> None:
    assert read(message) == [(identifier, data)]


@pytest.mark.parametrize(
    "given",
    [
        plain(0x800), plain(-0x1A), plain(0x20000000, is_extended_id=True), plain(-1, is_extended_id=True),
        ValueError("no number"), IndexError("too short"),
    ],
)  # fmt: skip
def test_what_is_no_frame_is_an_error_record_and_what_follows_is_read(given: can.Message | Exception) -> None:
    assert read(given, plain(5, b"z")) == [(ERROR, b""), (5, b"z")]


def test_a_bus_off_ends_the_link_with_what_to_do() -> None:
    port = CanPort(Given("x", plain(0x44, bytes(8), is_error_frame=True)), "the bus", 0.0)
    with pytest.raises(LinkLost, match=r"the bus.*bus-off: too many errors"):
        port.read(SIZE)


@pytest.mark.parametrize(("most", "frames"), [(0, 1), (SIZE, 1), (2 * SIZE - 1, 1), (2 * SIZE, 2), (9 * SIZE, 3)])
def test_no_more_is_read_than_asked_for_but_one_frame(most: int, frames: int) -> None:
    given = [plain(number) for number in (1, 2, 3)]
    assert [identifier for identifier, _ in read(*given, most=most)] == [1, 2, 3][:frames]


def test_nothing_is_read_from_a_silent_bus() -> None:
    assert read() == []


def test_the_first_frame_is_waited_for_and_no_longer() -> None:
    bus = Given("x", plain(1))
    CanPort(bus, "x", 1e6).read(2 * SIZE - 1)
    assert bus.waited[0] == pytest.approx(1e6, rel=1e-2)
    bus = Given("x", plain(1))
    bus.given.append(plain(2))
    CanPort(bus, "x", 60.0).read(2 * SIZE)
    assert bus.waited[1] is not None
    assert 0.0 <= bus.waited[1] <= can_port.GATHER_S


@pytest.mark.parametrize(("state", "is_lost"), [(can.BusState.ERROR, True), (can.BusState.PASSIVE, False)])
def test_a_silent_bus_that_is_off_is_a_lost_link(
    state: can.BusState, is_lost: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(can_port, "SILENT_S", -1.0)
    bus = Given("x", plain(1))
    bus.ails = state
    port = CanPort(bus, "x", 0.0)
    assert len(port.read(SIZE)) == SIZE  # while frames come nobody asks
    if is_lost:
        with pytest.raises(LinkLost, match="bus-off"):
            port.read(SIZE)
    else:
        assert port.read(SIZE) == b""


def test_a_bus_that_has_just_fallen_silent_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(can_port, "SILENT_S", 1e9)
    bus = Given("x")
    bus.ails = can.BusState.ERROR
    assert CanPort(bus, "x", 0.0).read(SIZE) == b""


def test_a_port_only_listens() -> None:
    CanPort(Given("x"), "x", 0.0).write(b"whatever")


@pytest.mark.parametrize("error", [can.CanOperationError("gone"), OSError("gone"), RuntimeError("gone")])
def test_an_adapter_that_is_gone_is_closed_without_a_word(error: Exception) -> None:
    class Gone(Given):
        def shutdown(self) -> None:
            super().shutdown()
            raise error

    CanPort(Gone("x"), "x", 0.0).close()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("False", False),
        ("TRUE", True),
        ("12", 12),
        ("-3", -3),
        ("0.5", 0.5),
        ("1e3", 1e3),
        ("a1", "a1"),
        ("", ""),
    ],
)
def test_options_are_the_values_that_python_can_wants(text: str, value: object) -> None:
    open_can("vector", "ch", {"name": text}, 0.0).close()
    (found,) = OPENED
    assert (found["name"], type(found["name"])) == (value, type(value))
    assert (found["channel"], found["bitrate"], found["listens"]) == ("ch", 0, False)


def test_every_option_is_handed_on_and_the_port_is_named_by_its_channel() -> None:
    port = open_can("vector", "/dev/x", {"bitrate": "500000", "listens": "true"}, 0.0)
    assert OPENED == [{"channel": "/dev/x", "bitrate": 500000, "name": "", "listens": True}]
    assert port.name == "/dev/x"
    port.close()


@pytest.mark.parametrize(
    ("interface", "channel", "options", "url", "found", "expected"),
    [
        ("vector", "/dev/x", {"bitrat": "5"}, "can://vector/dev/x", "option 'bitrat'", OPTIONS),
        ("vector", "x", {"channel": "y"}, "can://vector/x", "option 'channel'", OPTIONS),
        ("pigeon", "x", {}, "can://pigeon/x", "interface 'pigeon'", f"one of {', '.join(sorted(BACKENDS))}"),
    ],
)  # fmt: skip
def test_what_is_not_accepted_is_told_with_what_is(
    interface: str, channel: str, options: dict[str, str], url: str, found: str, expected: str
) -> None:
    with pytest.raises(BadDeviceUrl) as refused:
        open_can(interface, channel, options, 0.0)
    assert (refused.value.url, refused.value.found, refused.value.expected) == (url, found, expected)


def test_an_interface_that_is_not_installed_is_told() -> None:
    with pytest.raises(PortNotFound, match="pcan: No module named") as refused:
        open_can("pcan", "x", {}, 0.0)
    assert refused.value.advice == "install what this interface needs"


@pytest.mark.parametrize(
    ("channel", "kind"),
    [
        ("denied", PortDenied),
        ("forbidden", PortDenied),
        ("busy", PortBusy),
        ("again", PortBusy),
        ("cause", PortBusy),
        ("context", PortDenied),
        ("absent", PortNotFound),
        ("odd", PortNotFound),
    ],
)
def test_why_a_bus_does_not_open_is_told(channel: str, kind: type[Exception]) -> None:
    with pytest.raises(kind) as refused:
        open_can("vector", channel, {}, 0.0)
    assert channel in str(refused.value)
    assert "slcand" not in str(refused.value)
    if kind is PortNotFound:
        assert "no CAN bus" in str(refused.value)
        assert "check the adapter, its name, and what the interface needs" in str(refused.value)


def test_a_busy_serial_line_can_be_shared_by_the_kernel() -> None:
    with pytest.raises(PortBusy, match="slcand -o -s8 /dev/busy slcan0, ip link set slcan0 up"):
        open_can("vector", "/dev/busy", {}, 0.0)
