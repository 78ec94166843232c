"""Samples as MAVLink HIGHRES_IMU, forward-right-down, whatever axes the other outputs have."""

import math
from contextlib import ExitStack

from drivers.addresses import host_and_port
from drivers.mavlink.imu_out import ImuOut, open_imu_out
from station.sending.outputs import About, CalibratedSamples
from station.sending.to_udp import refuse_unreachable
from station.text import plural


class MavlinkHighresImu:
    """Sends each sample to one address, or to those who asked."""

    is_over = False

    def __init__(self, out: ImuOut, about: About, name: str) -> None:
        self._out, self._C, self.name = out, about.C, name

    @property
    def dropped(self) -> int:
        """The messages that this machine did not take."""
        return self._out.port.refused

    def send(self, samples: CalibratedSamples) -> None:
        """Send samples, a message each."""
        self._out.keep_up()
        force, rate = (values @ self._C.T for values in (samples.f, samples.omega))
        rows = zip(samples.t.tolist(), force.tolist(), rate.tolist(), samples.temperature.tolist(), strict=True)
        for t, (fx, fy, fz), (p, q, r), temperature in rows:
            self._out.highres(t, (fx, fy, fz), (p, q, r), temperature if math.isfinite(temperature) else math.nan)

    def status(self) -> str:
        """Return who listens, and how many messages this machine did not take."""
        listeners = plural(self._out.port.peers, "listener")
        return f"{self.name}: {listeners}, {plural(self.dropped, 'sample')} not taken by this machine"

    def close(self) -> None:
        """Give the port back."""
        self._out.close()


def open_output(where: str, about: About) -> MavlinkHighresImu:
    """Return the output of ``udpout:HOST:PORT`` or ``udpin:HOST:PORT``; see `open_imu_out` for what is refused."""
    out = open_imu_out(where)
    link, _, rest = where.partition("?")[0].partition(":")
    with ExitStack() as stack:
        stack.callback(out.close)
        if link == "udpout" and (peer := host_and_port(rest)):
            refuse_unreachable(*peer)
        stack.pop_all()
    return MavlinkHighresImu(out, about, f"mavlink:{link}:{rest}")
