"""``station devices``: which ports there are, and what comes out of one."""

from typing import Annotated

import typer

from station.commands import Database


def devices(
    url: Annotated[
        str | None,
        typer.Option("--url", metavar="URL", help="Look at what this device sends."),
    ] = None,
    seconds: Annotated[float, typer.Option("--seconds", metavar="S", min=0.1, help="For how long.")] = 2.0,
    db: Database = None,
) -> None:
    """List the serial ports, or look at one device: format, frames/s, errors, model and serial number.

    Of a MAVLink link: who is on it, what each message's rate is, and where its receiver stands.

    Exit code 4 if the port cannot be opened, is silent, or sends no frame of any known format.

    Example: station devices --url serial:///dev/ttyUSB0?baud=921600
    """
    from drivers.ports import list_ports

    if url is None:
        ports = list_ports()
        for port in ports:
            number = f", serial number {port.serial_number}" if port.serial_number else ""
            timer = "" if port.latency_ms is None else f", holds bytes for {port.latency_ms} ms"
            typer.echo(f"serial://{port.device}  {port.description}{number}{timer}")
        if not ports:
            typer.echo("no serial port is present")
        return
    if url.startswith("mavlink:"):
        from station.gnss.listening import listen

        for line in listen(url, seconds):
            typer.echo(line)
        return
    from station.reader.look import look

    seen = look(url, seconds)
    typer.echo(f"format    {seen.format}")
    typer.echo(f"unit      {seen.model or 'model not said'}, serial number {seen.serial or 'not said'}")
    typer.echo(f"received  {seen.frames / seen.seconds:.1f} frames/s, {seen.bytes / seen.seconds:.0f} bytes/s")
    if seen.rate_hz is not None:
        typer.echo(f"rate      {seen.rate_hz:.6g} Hz by the device's own time")
    counters = seen.counters
    typer.echo(
        f"errors    {counters.bad_crc} bad check, {counters.bad_length} bad length, "
        f"{counters.counter_jumps} breaks, {counters.bad_status} unhealthy, "
        f"{counters.skipped_bytes} bytes in no frame"
    )
    if counters.incomplete or counters.late or counters.foreign or counters.bus_errors:
        typer.echo(
            f"bus       {counters.incomplete} samples missing frames, {counters.late} frames late or repeated, "
            f"{counters.foreign} of others, {counters.bus_errors} bus errors"
        )
