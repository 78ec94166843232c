"""``station record``: what a device sends, to a file."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database


def record(
    url: Annotated[str, typer.Argument(metavar="URL", help="The IMU, as in serial:///dev/ttyUSB0?format=counts.")],
    out: Annotated[Path, typer.Option("--out", metavar="FOLDER", help="A new folder for the recording.")],
    gnss: Annotated[
        str, typer.Option("--gnss", metavar="URL", help="A GNSS receiver, as in mavlink:udpin:0.0.0.0:14550.")
    ] = "",
    seconds: Annotated[
        float, typer.Option("--seconds", metavar="S", min=0.0, help="Device time to record.")
    ] = float("inf"),
    db: Database = None,
) -> None:
    """Record the raw bytes and the counts of a device; Ctrl-C ends it and keeps what was recorded.

    In the folder: session_*.mcap with every byte since the port was opened, written by the reader process, and
    recording.mcap with bytes and counts of the seconds [s, device time] asked for; both open in Foxglove. With
    --gnss also gnss_session_*.mcap (its bytes) and gnss_*.mcap (its fixes), and UTC beside the rows.

    Exit code 4 if port or device fail, 130 on Ctrl-C.

    Example: station record serial:///dev/ttyUSB0?format=counts --seconds 60 --out r1
    """
    from station.gnss import open_gnss
    from station.gnss.sample_rate import Timed
    from station.gnss.summary import summary
    from station.guide.folder import journal_path, new_folder
    from station.live.live_feed import open_feed
    from station.reader import Reader
    from station.recorder import recording

    with ExitStack() as stack:
        folder = stack.enter_context(new_folder(out, recording.NAME))
        reader = stack.enter_context(Reader(url, journal_path(folder)))
        receiver = stack.enter_context(open_gnss(gnss, folder)) if gnss else None
        feed = open_feed(reader)
        timed = Timed(receiver, feed) if receiver else None
        try:
            done = recording.record(feed, folder, seconds, timed)
        finally:
            counters, framing = feed.stream.counters, feed.stream.decoder.counters
            typer.echo(
                f"{out / recording.NAME}: {counters.samples} samples of {feed.wire.name}, "
                f"{counters.breaks} breaks ({counters.lost} frames lost), "
                f"{counters.repeated} repeated, {counters.restarts} restarts, "
                f"{framing.bad_crc} bad check, {framing.skipped_bytes} bytes in no frame"
            )
            if zeros := feed.stream.decoder.kind.zeros:
                typer.echo(f"{feed.wire.name} does not measure {', '.join(zeros)}: 0 stands there")
            if receiver is not None and timed is not None:
                typer.echo(summary(receiver))
                if timed.said:
                    typer.echo(f"warning: {timed.said}", err=True)
    typer.echo(f"{done.seconds:.3f} s of device time, {done.samples} samples")
