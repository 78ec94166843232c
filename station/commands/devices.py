"""``station devices``: which ports there are, and what comes out of them."""

from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._options import flag, option

if TYPE_CHECKING:
    from collections.abc import Sequence

    from station.port_detection import SurveyedPort

RATE_TOLERANCE = 0.5  # of the declared rate; a look is short
CLEAR = "\x1b[H\x1b[2J"


def devices(
    url: Annotated[list[str] | None, option("URL", "Check what this device sends; repeatable.")] = None,
    seconds: Annotated[float, option("S", "For how long.", min=0.1)] = 2.0,
    watch: Annotated[bool, flag("--watch", "Repeat until Ctrl-C.")] = False,
    json: Annotated[bool, flag("--json", "Write JSON, one line per check.")] = False,
    db: Database = None,
) -> None:
    """List serial ports, CAN interfaces and MAVLink systems and what each sends, or check one device in detail.

    Every port is read for --seconds: likely format, frames/s, samples/s, errors. Nothing is sent to a port that is
    only listed. For a MAVLink link with --url: systems, the rate of each message, and the receiver's position. For
    a camera: images/s, size in px, bytes/s.

    Exit code 4 if a port given with --url cannot be opened, is silent, or sends no frame of any known format, or a
    camera sends no image.

    Example: station devices --url serial:///dev/ttyUSB0?baud=921600
    """
    from drivers.addresses import whole_url
    from station.port_detection import SurveyedPort, ports_present, survey

    url = [whole_url(each) for each in url or ()]
    if url and len(url) == 1 and not watch and not json:
        _closely(url[0], seconds)
        return
    try:
        while True:
            found = survey([SurveyedPort(each) for each in url] if url else ports_present(), seconds)
            _show(found, json=json, clear=watch)
            if not watch:
                break
    except KeyboardInterrupt:
        return
    if url and any(each.trouble for each in found):
        raise typer.Exit(4)


def _show(found: "Sequence[SurveyedPort]", *, json: bool, clear: bool) -> None:
    import sys
    from dataclasses import asdict
    from datetime import datetime
    from json import dumps
    from shutil import get_terminal_size

    from station.port_detection import fit_lines, port_lines

    if json:
        typer.echo(dumps({"format": "devices/1", "devices": [asdict(each) for each in found]}))
    else:
        lines = list[str]()
        for each in found:
            pace = _pace(each.url, each.frames_s, each.rate_hz)
            lines += [*port_lines(each), *([f"    warning: {pace}"] if pace else [])]
        if sys.stdout.isatty():
            width, height = get_terminal_size()
            lines = fit_lines(lines, width, height - 2 if clear else len(lines) * width)
        head = [f"{datetime.now():%H:%M:%S}  {len(found)} checked; Ctrl-C stops"] if clear else []
        typer.echo((CLEAR if clear and sys.stdout.isatty() else "") + "\n".join([*head, *lines]))
    sys.stdout.flush()


def _pace(url: str, came_hz: float, rate_hz: float | None) -> str:
    """Return what to say of samples that come much faster or slower than they say, empty where they do not."""
    if rate_hz is None or url.startswith(("replay:", "camera:")) or abs(came_hz / rate_hz - 1) <= RATE_TOLERANCE:
        return ""
    return f"{came_hz:.3g} Hz by this computer's clock; check sample period and sync line"


def _closely(url: str, seconds: float) -> None:
    if url.startswith(("mavlink:", "camera:")):
        from station.device_probe import probe_camera, probe_gnss

        seen = probe_camera(url, seconds) if url.startswith("camera:") else probe_gnss(url, seconds)
        typer.echo("\n".join(seen.lines()))
        return
    from drivers.wire import ALL_CHANNELS
    from station.device_probe import probe_imu
    from station.text import plural

    imu = probe_imu(url, seconds)
    typer.echo(f"format    {imu.format}")
    typer.echo(f"unit      {imu.model or 'model not sent'}, serial number {imu.serial or 'not sent'}")
    typer.echo(f"received  {imu.frames / imu.seconds:.1f} frames/s, {imu.bytes / imu.seconds:.0f} bytes/s")
    if imu.rate_hz is not None:
        typer.echo(f"rate      {imu.rate_hz:.6g} Hz by the device's own clock")
    if lacking := sorted(ALL_CHANNELS - imu.channels):
        typer.echo(f"measures  {', '.join(sorted(imu.channels))}; not {', '.join(lacking)}")
    if imu.silent:
        typer.echo(f"warning   {imu.silent}")
    if pace := _pace(url, imu.frames / imu.seconds, imu.rate_hz):
        typer.echo(f"warning   {pace}")
    counters = imu.counters
    typer.echo(
        f"errors    {counters.bad_crc} bad check, {counters.bad_length} bad length, "
        f"{plural(counters.counter_jumps, 'break')}, {counters.bad_status} unhealthy, "
        f"{plural(counters.skipped_bytes, 'byte')} in no frame"
    )
    if counters.incomplete or counters.late or counters.foreign or counters.bus_errors:
        typer.echo(
            f"bus       {plural(counters.incomplete, 'sample')} missing frames, "
            f"{plural(counters.late, 'frame')} late or repeated, "
            f"{counters.foreign} of others, {plural(counters.bus_errors, 'bus error')}"
        )
