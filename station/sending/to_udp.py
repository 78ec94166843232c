"""Calibrated samples over UDP, each a datagram of 96 bytes, little-endian.

docs/how-to/streaming.md has the table and two readers.
Each field stands at a multiple of its own size, so that a C compiler lays a struct out the same way.
"""

import secrets
import socket
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import PortNotFound, reason_of
from drivers.network_ports import UdpPort, open_udp
from station.sending.outputs import About, CalibratedSamples, peer_of
from station.text import plural

MAGIC = b"FOG1"  # the layout's name; another layout has another

DATAGRAM = np.dtype([
    ("magic", "S4"),
    ("flags", "<u4"),         # bits, as docs/how-to/streaming.md lists them
    ("sequence", "<u8"),      # rises by 1 with each sample sent
    ("t_s", "<f8"),           # device time
    ("utc_s", "<f8"),         # since 1970-01-01; NaN: not known
    ("f_m_s2", "<f8", 3),     # specific force
    ("omega_rad_s", "<f8", 3),  # angular rate
    ("temperature_c", "<f8"),   # NaN: not known
    ("lost", "<u4"),          # samples that the device's counter misses before this one
    ("run", "<u4"),           # of the sender: another number is another beginning of ``sequence``
])  # fmt: skip


def datagrams(fields: Mapping[str, NDArray[Any]], run: int) -> list[bytes]:
    """Return the datagrams of n samples, ``fields`` (n,) or (n, 3) by their names in `DATAGRAM`."""
    n = len(fields["sequence"])
    rows = np.zeros(n, DATAGRAM)
    rows["magic"], rows["run"] = MAGIC, run
    for name, values in fields.items():
        rows[name] = values
    size, all_bytes = DATAGRAM.itemsize, rows.tobytes()
    return [all_bytes[at : at + size] for at in range(0, n * size, size)]


EXPECTED = "udp:HOST:PORT, as in udp:127.0.0.1:5005"
# Linux gives a reader that asks for nothing room for about 270 datagrams: what waited while this machine was busy
# goes in bursts of a tenth of that, faster than any IMU samples but not all at once.
BURST = 32  # datagrams sent without a pause
PAUSE_S = 1e-3  # s between bursts, 32,000 samples a second


class UdpDatagrams:
    """Sends each sample to one address; who does not listen is not an error."""

    is_over = False

    def __init__(self, port: UdpPort) -> None:
        self._port, self.name = port, f"udp:{port.name}"
        self._run = secrets.randbits(32)

    @property
    def dropped(self) -> int:
        """The datagrams that this machine did not take."""
        return self._port.refused

    def send(self, samples: CalibratedSamples) -> None:
        """Send samples, a datagram each, in bursts of at most `BURST`."""
        fields: dict[str, NDArray[Any]] = {
            "flags": samples.flags, "sequence": samples.sequence, "t_s": samples.t, "utc_s": samples.utc,
            "f_m_s2": samples.f, "omega_rad_s": samples.omega, "temperature_c": samples.temperature,
            "lost": samples.lost,
        }  # fmt: skip
        for i, datagram in enumerate(datagrams(fields, self._run)):
            if i and i % BURST == 0:
                time.sleep(PAUSE_S)
            self._port.write(datagram)

    def status(self) -> str:
        """Return how many datagrams this machine did not take; what a reader misses only the reader can count."""
        return f"{self.name}: {plural(self.dropped, 'sample')} not taken by this machine"

    def close(self) -> None:
        """Give the port back."""
        self._port.close()


def open_output(where: str, about: About) -> UdpDatagrams:
    """Return the output to HOST:PORT.

    Raise `BadAddress` or `PortNotFound` if that is no address, or no way leads there.
    """
    host, port = peer_of("udp", where, EXPECTED)
    refuse_unreachable(host, port)
    return UdpDatagrams(open_udp(host, port, 0.0, listens=False))


def refuse_unreachable(host: str, port: int) -> None:
    """Raise `PortNotFound` for a host that has no address or that no way leads to."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.connect(address)  # sends nothing: it only asks this machine for the way
    except (OSError, UnicodeError) as error:
        raise PortNotFound(f"{host}:{port}", reason_of(error), "check the host's name and the network") from error
