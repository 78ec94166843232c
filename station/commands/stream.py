"""``station stream``: calibrated samples of a live device, wherever they are needed."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import (
    Axes,
    Model,
    Seconds,
    Serial,
    Speed,
    argument,
    end_on_signals,
    flag,
    option,
    refused_as,
)

FRAMES = ("sensor", "frd")


def stream(
    url: Annotated[
        str, argument("URL", "The IMU, as in serial:///dev/ttyUSB0?format=counts, or replay:FILE.")
    ] = "",
    to: Annotated[
        list[str] | None,
        option("OUTPUT", "foxglove[:HOST:PORT], udp:HOST:PORT, mavlink:udpout:HOST:PORT, stdout; repeatable."),
    ] = None,
    calibration: Annotated[str, option("FILE|SERIAL", "A calibration.json, or a unit's newest stored one.")] = "",
    nominal: Annotated[bool, flag("--nominal", "The maker's scale factors, no calibration.")] = False,
    gnss: Annotated[str, option("URL", "A receiver, for UTC: mavlink:udpin:0.0.0.0:14550.")] = "",
    frame: Annotated[str, option("FRAME", "sensor, or frd: forward-right-down.")] = "sensor",
    axes: Axes = "x,-y,-z",
    seconds: Seconds = float("inf"),
    folder: Annotated[Path | None, option("FOLDER", "A new folder that keeps every byte, for a replay.")] = None,
    speed: Speed = 1.0,
    layout: Annotated[
        Path | None, option("FILE", "Write a layout for Foxglove there, and do nothing else.")
    ] = None,
    model: Model = "",
    serial: Serial = "",
    db: Database = None,
) -> None:
    """Stream calibrated samples live: specific force [m/s2], angular rate [rad/s], device time [s].

    Each sample has a sequence number, UTC [s since 1970] with --gnss, temperature [degC], and flags such as
    gap_before or saturated. Outputs: foxglove is a live server for Foxglove (extra `foxglove`; port 8765 of this
    computer by default), udp a datagram of 96 bytes per sample, mavlink HIGHRES_IMU, stdout a line of JSON per
    sample (the default without --to). Layouts, flags and readers in Python and C: docs/how-to/streaming.md.

    Without --calibration it is the newest stored one of the connected unit; that of another unit is refused.
    Samples are in the IMU's own axes; --frame frd rotates them as --axes states, as always for MAVLink. An output
    never waits for a reader: samples without room are discarded, counted and reported on stderr every 10 s and at
    the end.

    A lost port is tried again for 30 s, as in `station record`. Exit code 2 if an output's address is wrong or its
    extra missing, 3 if there is no calibration or one of another unit, 4 if a port cannot be opened or the device
    is gone, 130 on Ctrl-C.

    Example: station stream serial:///dev/ttyUSB0?format=counts --to foxglove --to udp:127.0.0.1:5005
    """
    if layout is not None:
        from station.sending.to_foxglove import write_layout

        write_layout(layout)
        typer.echo(f"{layout}: a layout; in Foxglove: Layouts, Import from file")
        return
    if not url:
        raise typer.BadParameter("no device; expected its URL, as in serial:///dev/ttyUSB0", param_hint="URL")
    if frame not in FRAMES:
        raise typer.BadParameter(f"found {frame!r}, expected one of {', '.join(FRAMES)}", param_hint="--frame")
    if nominal and calibration:
        raise typer.BadParameter("--nominal and --calibration; expected one of them")
    from drivers.addresses import whole_url
    from station.calibrated.output_frame import body_axes
    from station.sending.outputs import kind_of
    from station.sending.sender import StreamRequest, run

    with refused_as("--axes"):
        C = body_axes(axes)
    wanted = StreamRequest(
        url=whole_url(url), to=to or ["stdout"], C=C, frd=frame == "frd", gnss=gnss, calibration=calibration,
        nominal=nominal, seconds=seconds, speed=speed, folder=folder, model=model, serial=serial, database=db,
    )  # fmt: skip
    for text in wanted.to:
        kind_of(text)
    end_on_signals()
    run(wanted, lambda line: typer.echo(line, err=True))
