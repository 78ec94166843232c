"""Survey many ports at once and report what each sends. Nothing is sent to a port found.

A serial port is read at the usual baud rate; where bytes come and look like nothing, at the others too.
"""

import re
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from textwrap import wrap

from drivers.address_parsing import parse_device_url
from drivers.addresses import DEFAULT_BAUD, SerialAddress
from drivers.errors import DriverError
from drivers.framing import sniff
from drivers.network_ports import open_udp
from drivers.port_interface import Port
from drivers.ports import open_port, wire_of
from drivers.serial_port import list_ports
from drivers.wire import FORMATS
from procedures.gnss_records import GnssFix, averaged_site
from station.device_probe import FORMAT, probe_bytes, probe_camera, read_for

GROUND_STATION = "mavlink:udpin:127.0.0.1:14550"  # where routers of this machine send to; others: by --url
BAUDS = tuple(dict.fromkeys((DEFAULT_BAUD, *(wire.baud for wire in FORMATS.values()), 115200, 57600)))
ARPHRD_CAN = "280"  # linux/if_arp.h
SLCAN = re.compile(rb"\r[tT][0-9A-Fa-f]{4,9}[0-9A-Fa-f]*(?=\r)")
TIMEOUT_S = 0.05
INDENT_CHARS = 4


@dataclass(frozen=True, slots=True)
class SurveyedPort:
    """A port and what came out of it.

    ``url`` opens it, ``about`` is what it says of itself, ``looks_like`` the format of its bytes, ``mavlink`` or
    ``slcan``, empty if none. Rates are per second; ``rate_hz`` is by the device's own time. ``errors`` are what
    the framing counted, ``position`` is where a receiver stands in words, ``systems`` and ``messages`` MAVLink's
    frames per second. ``trouble`` says what is wrong.
    """

    url: str
    about: str = ""
    looks_like: str = ""
    model: str | None = None
    serial: str | None = None
    frames_s: float = 0.0
    bytes_s: float = 0.0
    rate_hz: float | None = None
    errors: dict[str, int] = field(default_factory=dict)
    position: str = ""
    systems: dict[int, float] = field(default_factory=dict)
    messages: dict[str, float] = field(default_factory=dict)
    trouble: str = ""


def ports_present() -> list[SurveyedPort]:
    """Return serial ports, CAN interfaces of the kernel, and the port that ground stations listen on."""
    found = []
    for port in list_ports():
        number = f", serial number {port.serial_number}" if port.serial_number else ""
        timer = "" if port.latency_ms is None else f", holds bytes for {port.latency_ms} ms"
        found.append(SurveyedPort(f"serial://{port.device}", f"{port.description}{number}{timer}"))
    for kind in sorted(Path("/sys/class/net").glob("*/type")):
        if kind.read_text().strip() == ARPHRD_CAN:
            found.append(SurveyedPort(f"can://socketcan/{kind.parent.name}", "CAN interface"))
    return [*found, SurveyedPort(GROUND_STATION, "MAVLink, the ground station's port")]


def survey(ports: Iterable[SurveyedPort], seconds: float) -> list[SurveyedPort]:
    """Look at all ports at once, for ``seconds`` each; what cannot be opened says so in ``trouble``."""
    wanted = list(ports)
    with ThreadPoolExecutor(max(1, len(wanted))) as pool:
        return list(pool.map(lambda port: _looked_at(port, seconds), wanted))


def _looked_at(port: SurveyedPort, seconds: float) -> SurveyedPort:
    try:
        address = parse_device_url(port.url)
        if address.scheme == "camera":
            return _camera(port, seconds)
        wire_of(address)  # a wrong DBC or mapping is reported before a port is waited for
        if address.scheme != "serial" or "baud=" in port.url or address.format:
            return recognise_bytes(port, *read_for(_open(port.url), seconds))
        for baud in BAUDS:
            url = f"{port.url}?baud={baud}"
            data, took = read_for(open_port(url, TIMEOUT_S), seconds)
            found = recognise_bytes(replace(port, url=url), data, took)
            if found.looks_like or not data:
                return found
        return replace(found, url=port.url, trouble=f"{found.trouble} at {', '.join(map(str, BAUDS))} baud")
    except DriverError as error:
        return replace(port, trouble=str(error))


def _camera(port: SurveyedPort, seconds: float) -> SurveyedPort:
    seen = probe_camera(port.url, seconds, TIMEOUT_S)
    return replace(
        port, about=seen.size, looks_like=FORMAT, frames_s=seen.images / seen.seconds,
        bytes_s=seen.bytes / seen.seconds, rate_hz=seen.rate_hz, errors=seen.errors,
    )  # fmt: skip


def _open(url: str) -> Port:
    if url == GROUND_STATION:  # found, not asked for: only listen
        return open_udp("127.0.0.1", 14550, TIMEOUT_S, listens=True)
    return open_port(url, TIMEOUT_S)


def recognise_bytes(port: SurveyedPort, data: bytes, seconds: float) -> SurveyedPort:
    """Return the port with what its bytes are."""
    if not data:
        return replace(port, trouble=f"no bytes within {seconds:.1f} s")
    port = replace(port, bytes_s=len(data) / seconds)
    address = parse_device_url(port.url)
    likely = sniff(data) if address.scheme in {"serial", "tcp", "replay"} else []
    wire = wire_of(address) or (FORMATS[likely[0].format] if likely else None)
    if wire is not None and (seen := probe_bytes(wire, data, seconds)) is not None:
        kept = {name: n for name, n in asdict(seen.counters).items() if name not in {"frames", "identities"}}
        return replace(
            port, looks_like=seen.format, model=seen.model, serial=seen.serial, frames_s=seen.frames / seconds,
            rate_hz=seen.rate_hz, errors=kept,
        )  # fmt: skip
    if address.scheme != "can" and (found := _mavlink(port, data, seconds)) is not None:
        return found
    if len(SLCAN.findall(data)) > 1:
        url = f"can://slcan{address.path if isinstance(address, SerialAddress) else ''}"
        return replace(port, looks_like="slcan", trouble=f"an open CAN adapter: look at {url}")
    return replace(port, trouble=f"{len(data)} bytes hold no frame of any known format")


def _mavlink(port: SurveyedPort, data: bytes, seconds: float) -> SurveyedPort | None:
    from drivers.mavlink.gnss_fixes import MavlinkDecoder  # pymavlink: only where a port needs it
    from station.stream.gnss_feed import site_in_words

    decoder = MavlinkDecoder()
    fixes = [one for one in decoder.feed(data, time.monotonic_ns()) if isinstance(one, GnssFix)]
    site = averaged_site([fix for fix in fixes if fix.source == "GPS_RAW_INT"] or fixes)
    counters = decoder.framer.counters
    if not decoder.systems:
        return None
    errors = {name: getattr(counters, name) for name in ("bad_crc", "lost", "skipped_bytes")}
    return replace(
        port, looks_like="mavlink", url=port.url.replace("serial://", "mavlink:serial:"),
        frames_s=sum(decoder.systems.values()) / seconds, errors=errors,
        position="no position" if site is None else site_in_words(site),
        systems={system: count / seconds for system, count in sorted(decoder.systems.items())},
        messages={name: count / seconds for name, count in sorted(decoder.messages.items())},
    )  # fmt: skip


def fit_lines(lines: Sequence[str], width: int, height: int) -> list[str]:
    """Return lines broken between words to a terminal's width; what is too much for its height is counted."""
    broken = [
        part
        for line in lines
        for part in wrap(line, width, subsequent_indent=" " * 2 * INDENT_CHARS, break_on_hyphens=False)
    ]
    if len(broken) <= height:
        return broken
    return [*broken[: height - 1], f"... {len(broken) - height + 1} more lines: --url URL looks at one alone"]


def port_lines(found: SurveyedPort) -> list[str]:
    """Return two lines or more: a port's address, then what comes out of it."""
    lines = [f"{found.url}  {found.about}".rstrip()]
    if not found.looks_like or found.trouble:
        return [*lines, f"{'':{INDENT_CHARS}}{found.trouble}"]
    named = [found.looks_like, found.model or "", f"serial number {found.serial}" if found.serial else ""]
    rates = [f"{found.frames_s:.1f} frames/s", f"{found.bytes_s:.0f} bytes/s"]
    if found.rate_hz is not None:
        rates.append(f"{found.rate_hz:.6g} Hz by its own time")
    bad = [f"{count} {name.replace('_', ' ')}" for name, count in found.errors.items() if count]
    wording = [", ".join(part for part in [*named, *rates] if part)]
    wording += [f"system {system}: {rate:.1f} frames/s" for system, rate in found.systems.items()]
    if found.position:
        wording.append(f"receiver: {found.position}")
    if found.messages:
        wording.append(", ".join(f"{name} {rate:.1f} Hz" for name, rate in found.messages.items()))
    return [*lines, *(f"{'':{INDENT_CHARS}}{text}" for text in [*wording, f"errors: {', '.join(bad) or 'none'}"])]
