"""``station record``: what a device sends, to a file."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database


def record(
    url: Annotated[str, typer.Argument(metavar="URL", help="The IMU, as in serial:///dev/ttyUSB0?format=counts.")],
    out: Annotated[Path, typer.Option("--out", metavar="FOLDER", help="A new folder for the recording.")],
    seconds: Annotated[
        float, typer.Option("--seconds", metavar="S", min=0.0, help="Device time to record.")
    ] = float("inf"),
    db: Database = None,
) -> None:
    """Record the raw bytes and the counts of a device; Ctrl-C ends it and keeps what was recorded.

    In the folder: session_*.mcap with every byte since the port was opened, written by the reader process, and
    recording.mcap with bytes and counts of the seconds [s, device time] asked for; both open in Foxglove.

    Exit code 4 if port or device fail, 130 on Ctrl-C.

    Example: station record serial:///dev/ttyUSB0?format=counts --seconds 60 --out r1
    """
    from station.guide.folder import journal_path, new_folder
    from station.live.live_feed import open_feed
    from station.reader import Reader
    from station.recorder import recording

    with new_folder(out, recording.NAME) as folder, Reader(url, journal_path(folder)) as reader:
        feed = open_feed(reader)
        try:
            done = recording.record(feed, folder, seconds)
        finally:
            counters, framing = feed.stream.counters, feed.stream.decoder.counters
            typer.echo(
                f"{out / recording.NAME}: {counters.samples} samples of {feed.wire.name}, "
                f"{counters.breaks} breaks ({counters.lost} frames lost), "
                f"{counters.repeated} repeated, {counters.restarts} restarts, "
                f"{framing.bad_crc} bad check, {framing.skipped_bytes} bytes in no frame"
            )
    typer.echo(f"{done.seconds:.3f} s of device time, {done.samples} samples")
