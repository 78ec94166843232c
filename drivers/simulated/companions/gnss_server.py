"""Serves a simulated autopilot on a real transport: UDP, TCP or pty, beside a simulated IMU or alone."""

from collections.abc import Iterable
from pathlib import Path

from drivers.simulated.companions.autopilot import Autopilot
from drivers.simulated.companions.companion_device import CompanionDevice
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.serial_and_tcp_lines import PtyLine, TcpLine, UdpLine
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack

POLL_S = 0.002
IDLE_S = 0.02  # at most, where nothing is due: what is planted acts by then, what comes is heard at once


class SimulatedGnss(CompanionDevice):
    """An autopilot on a real transport while the ``with`` block lasts.

    Parameters
    ----------
    truth, autopilot, faults, track, seed
        What is simulated, see `Autopilot`.
    beside
        The device whose time it shares; without it, the host's, ``speed`` times as fast.
    transport, link, port, to
        ``udp`` (it listens on ``port``, or sends to ``to``), ``tcp`` on ``port``, or ``pty``; port 0: any.
    """

    def __init__(
        self,
        truth: Truth,
        autopilot: AutopilotTruth | None = None,
        faults: Iterable[TimedFault] = (),
        track: VehicleTrack | None = None,
        seed: int | None = 1,
        *,
        beside: SimulatedDevice | None = None,
        speed: float = 1.0,
        transport: str = "udp",
        link: Path | None = None,
        port: int = 0,
        to: tuple[str, int] | None = None,
    ) -> None:
        super().__init__("simulated autopilot", faults, beside, speed)
        self.autopilot = Autopilot(truth, autopilot, self.faults, track, seed)
        self._line = _line(transport, link, port, to)
        self._answer = b""

    @property
    def url(self) -> str:
        """The URL by which a station opens it."""
        return f"mavlink:{self._line.address.replace('://', ':', 1)}"

    def _plug(self) -> None:
        self._line.plug()

    def _unplug(self) -> None:
        self._line.unplug()

    def _step(self, now: float, *, is_plugged: bool) -> None:
        out = self._answer + self.autopilot.due(now)
        if not is_plugged:
            self._stop.wait(POLL_S)
            return
        heard = self._line.exchange(out, self._idle_s(now))
        self._answer = self.autopilot.hear(heard, now) if heard else b""

    def _idle_s(self, now: float) -> float:
        """Return how long [s] nothing is due from true time ``now`` on."""
        pace = self._beside.speed if self._beside else self._speed
        if not pace:  # as fast as it is read: nobody knows when
            return POLL_S
        return min(max((self.autopilot.next_due - now) / pace, POLL_S), IDLE_S)


def _line(transport: str, link: Path | None, port: int, to: tuple[str, int] | None) -> PtyLine | TcpLine | UdpLine:
    match transport:
        case "pty":
            return PtyLine(link)
        case "tcp":
            return TcpLine(port=port)
        case "udp":
            return UdpLine(port=port, to=to)
    raise ValueError(f"transport {transport!r}: expected udp, tcp or pty")
