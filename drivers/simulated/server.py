"""Serves a simulated device's bytes on a pty or a TCP port, and its cube's motion on a control port.

Paced by absolute deadlines, ``speed`` times device time; speed 0 or inf is as fast as the reader takes. Device
time waits for a reader, and for a guide that says what it has seen and falls behind.
"""

import contextlib
import socketserver
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from threading import Event, Thread
from typing import Self
from urllib.parse import urlencode

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.device import MAX_CHUNK_SAMPLES, ByteDevice, ScheduledMove
from drivers.simulated.faults import Fault, Sent, Silence
from drivers.simulated.lines import PtyLine, SlcanAdapter, TcpLine, UdpMulticastLine
from drivers.simulated.truth import Truth
from drivers.wire import WireFormat

CAN_TRANSPORTS = ("slcan", "udp_multicast")
TRANSPORTS = ("pty", "tcp", *CAN_TRANSPORTS)
MAX_COMMAND_BYTES = 256  # bytes
CHUNK_S = 0.01  # wall time a paced chunk aims at
FAST_CHUNK_S = 0.04  # the same of a device faster than time: what each chunk costs its reader adds up
MAX_BEHIND_S = 0.25  # a device later than this restarts its pace instead of hurrying after it
POLL_S = 0.05  # how long the control port takes to close
MAX_AHEAD_S = 120.0  # device time by which a paced device runs ahead of a guide that says what it has seen
MAX_WAIT_S = 5.0  # how long it waits for a guide that says no more


class SimulatedDevice:
    """A device on a real transport while the ``with`` block lasts.

    Parameters
    ----------
    truth, seed, faults
        What is simulated; equal ones give equal bytes for commands at equal device times.
    format
        Name of a wire format.
    speed
        Device seconds per second; 0 or inf: as fast as the reader takes.
    transport
        ``pty``, ``tcp``, or for CAN ``slcan`` (an adapter on a pty) or ``udp_multicast``.
    dbc, mapping
        The files that describe the frames on CAN; the station's own by default. ``format`` is for the others.
    link
        A path kept pointing at the pty, also after an unplug, when the kernel may give it another name.
    host, port
        Where a TCP device listens, port 0: any free one; of ``udp_multicast`` the port, 0: the usual one.
    control_port
        Loopback port of the hands; 0: any free one.
    moves
        What the hands do by themselves, in order of time.
    pps
        A pulse a second of true time is at its input, and its format reports it.
    hold
        Do not begin before the hands say ``go``: what they command first is then exact to the sample.
    """

    def __init__(
        self,
        truth: Truth,
        seed: int | None,
        format: str = "counts",
        speed: float = 1.0,
        *,
        transport: str = "pty",
        link: Path | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
        control_port: int = 0,
        faults: Iterable[Fault] = (),
        hold: bool = False,
        dbc: str = "",
        mapping: str = "",
        moves: Iterable[ScheduledMove] = (),
        pps: bool = False,
    ) -> None:
        self._line = _line(transport, link, host, port)
        wire: str | WireFormat = format
        self._options = {"format": format}
        if transport in CAN_TRANSPORTS:
            from drivers.can.can_format import can_format  # cantools takes 0.15 s to import

            wire = can_format(dbc, mapping, truth.sample_period_s)
            options = {"period_s": f"{truth.sample_period_s:.9g}", "dbc": dbc, "map": mapping}
            options |= {"port": f"{port}" if transport == "udp_multicast" and port else ""}
            self._options = {name: value for name, value in options.items() if value}
        self.device = ByteDevice(truth, seed, wire, faults, moves, pps=pps)
        self.truth, self.seed = self.device.truth, seed
        self.speed = speed if np.isfinite(speed) and speed > 0 else 0.0  # device seconds per second
        self._control_port = control_port
        self._stop, self._go = Event(), Event()
        if not hold:
            self._go.set()
        self._control: _ControlServer | None = None
        self._hands: BenchControl | None = None
        self._threads: list[Thread] = []
        self.failure: Exception | None = None
        self._true_period = self.truth.sample_period_s / (1 + 1e-6 * self.device.imu.world.clock_ppm)
        self._sent = 0  # samples
        self._seen: tuple[float, float] | None = None  # device time that the guide has seen, and when it did
        # true time of the last sample sent, when that was, how far the next are from it
        self._going = 0.0, 0.0, 0.0

    @property
    def true_time(self) -> float:
        """True time [s]; device time is off it by what is planted as ``clock.rate``.

        It goes on between one sending and the next, up to what is sent then: what stands with the device does
        not live in steps of its samples.
        """
        sent, at, ahead = self._going
        return sent + min((time.monotonic() - at) * self.speed, ahead)

    @property
    def time(self) -> float:
        """Device time [s] of the last sample sent."""
        return self._sent * self.truth.sample_period_s

    def plant(self, kind: str, count: int = 1, seconds: float = 1.0) -> None:
        """Have a fault act from now on, see `drivers.simulated.faults.KINDS`."""
        self.device.plant(kind, count, seconds)

    @property
    def hands(self) -> BenchControl:
        """The hands, called at their control address; hung up when the device ends."""
        self._hands = self._hands or BenchControl(self.control)
        return self._hands

    @property
    def address(self) -> str:
        """The port without a URL around it: a device file, or HOST:PORT."""
        return parse_device_url(self.url).name

    @property
    def url(self) -> str:
        """The device's URL, to be opened like any other."""
        return f"{self._line.address}?{urlencode(self._options, safe='/')}"

    @property
    def control(self) -> str:
        """HOST:PORT of the hands."""
        if self._control is None:
            raise RuntimeError("the simulated device is not served yet: enter its `with` block first")
        host, port = self._control.server_address[:2]
        return f"{host!s}:{port}"

    def __enter__(self) -> Self:
        self._line.plug()
        try:
            self._control = _ControlServer(("127.0.0.1", self._control_port), self._execute)
        except OSError:
            self._line.unplug()
            raise
        for target in (self._run, partial(self._control.serve_forever, POLL_S)):
            thread = Thread(target=target, name="simulated device", daemon=True)
            thread.start()
            self._threads.append(thread)
        return self

    def __exit__(self, *raised: object) -> None:
        self._stop.set()
        self._go.set()
        try:
            if self._hands is not None:
                self._hands.close()
            if self._control is not None:
                self._control.shutdown()
                self._control.server_close()
            for thread in self._threads:
                thread.join()
        finally:  # also after a second Ctrl-C: a link left behind soon points at another program's terminal
            self._line.unplug()

    def wait(self) -> None:
        """Serve until interrupted; raise what stopped the device, if anything did."""
        while not self._stop.wait(0.5):
            pass
        if self.failure is not None:
            raise self.failure

    def _execute(self, command: str) -> str:
        if command.split() == ["go"]:
            self._go.set()
            return "ok"
        match command.split():
            case ["seen", seen] if seen.replace(".", "", 1).isdecimal():
                self._seen = float(seen), time.monotonic()
                return "ok"
        return self.device.execute(command)

    def _run(self) -> None:
        self._go.wait()
        try:
            self._send_all()
        except Exception as error:  # the edge of a thread: kept for `wait`, and the line goes silent
            self.failure = error
            self._stop.set()

    def _send_all(self) -> None:
        pace = Pace(self.speed, self._true_period)
        while not self._stop.is_set():
            sent = self.device.chunk(pace.samples)
            self._stop.wait(pace.delay(self.device.samples))
            self._wait_for_guide()
            for part in sent:
                self._send(part)
                if isinstance(part, Silence):
                    pace.excuse(part.seconds / (self.speed or 1.0))
            self._sent = self.device.samples
            ahead = pace.samples * self._true_period if self.speed else 0.0
            self._going = self._sent * self._true_period, time.monotonic(), ahead

    def _wait_for_guide(self) -> None:
        while self.speed and self._seen is not None and not self._stop.is_set():
            seen, text = self._seen
            if self.time < seen + MAX_AHEAD_S or time.monotonic() > text + MAX_WAIT_S:
                return
            self._stop.wait(CHUNK_S)

    def _send(self, part: Sent) -> None:
        if not isinstance(part, Silence):
            self._line.write(part, self._stop)
            return
        if part.kind == "unplug":
            self._line.unplug()
        if isinstance(self._line, SlcanAdapter):
            self._line.ails = part.kind
        self._stop.wait(part.seconds / (self.speed or 1.0))
        if isinstance(self._line, SlcanAdapter):
            self._line.ails = ""
        if part.kind == "unplug" and not self._stop.is_set():
            self._line.plug()


def _line(transport: str, link: Path | None, host: str, port: int) -> PtyLine | TcpLine | UdpMulticastLine:
    match transport:
        case "pty":
            return PtyLine(link)
        case "tcp":
            return TcpLine(host, port)
        case "slcan":
            return SlcanAdapter(link)
        case "udp_multicast":
            return UdpMulticastLine(port)
    raise ValueError(f"transport {transport!r}: expected pty or tcp, or one of {', '.join(CAN_TRANSPORTS)}")


def serve(device: SimulatedDevice, announce: Callable[[SimulatedDevice], None]) -> None:
    """Serve ``device`` until interrupted; ``announce`` is called once it can be opened."""
    with device, contextlib.suppress(KeyboardInterrupt):
        announce(device)
        device.wait()


class _ControlServer(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True
    block_on_close = False

    def __init__(self, address: tuple[str, int], execute: Callable[[str], str]) -> None:
        self.execute = execute
        super().__init__(address, _Conversation)


class _Conversation(socketserver.StreamRequestHandler):
    server: _ControlServer

    def handle(self) -> None:
        with contextlib.suppress(ConnectionError):
            while line := self.rfile.readline(MAX_COMMAND_BYTES):
                answer = self.server.execute(line.decode("utf-8", "replace").strip())
                self.wfile.write(answer.encode() + b"\n")


class Pace:
    """Absolute deadlines of samples ``period`` [s] apart, ``speed`` device seconds per second; 0: no deadlines."""

    def __init__(self, speed: float, period: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_sample = period / speed if speed else 0.0
        self._chunk_s = FAST_CHUNK_S if speed > 1 else CHUNK_S
        self._clock = clock
        self._anchor, self._anchored = clock(), 0
        self._allowed = MAX_BEHIND_S

    def excuse(self, seconds: float) -> None:
        """Take it that the device was held up on purpose: what became due meanwhile is not waited for again."""
        self._allowed = MAX_BEHIND_S + seconds

    @property
    def samples(self) -> int:
        """Samples to take at a time."""
        wanted = round(self._chunk_s / self._per_sample) if self._per_sample else MAX_CHUNK_SAMPLES
        return min(MAX_CHUNK_SAMPLES, max(1, wanted))

    def delay(self, sample: int) -> float:
        """Return how long [s] to wait until ``sample`` is due."""
        if not self._per_sample:
            return 0.0
        now = self._clock()
        early = self._anchor + (sample - self._anchored) * self._per_sample - now
        if early > -MAX_BEHIND_S:
            self._allowed = MAX_BEHIND_S
        elif early < -self._allowed:
            self._anchor, self._anchored = now, sample
        return max(0.0, early)
