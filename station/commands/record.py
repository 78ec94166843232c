"""``station record``: what a device sends, to a file."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._options import Gnss, Model, Serial, argument, lengths, option, refused_as
from station.text import plural

if TYPE_CHECKING:
    from station.stream.camera import CameraFeed
    from station.stream.gnss_feed import GnssFeed
    from station.stream.live.live_feed import LiveFeed
    from station.stream.sample_rate import SampleRate
    from station.stream.wheel import WheelFeed


def record(
    url: Annotated[str, argument("URL", "The IMU, as in serial:///dev/ttyUSB0?format=counts.")],
    out: Annotated[Path | None, option("FOLDER", "A new folder for the recording.")] = None,
    gnss: Gnss = "",
    camera: Annotated[Path | None, option("FILE", "A camera, as its camera/1 file describes it.")] = None,
    wheel: Annotated[
        Path | None, option("FILE", "A vehicle's speed on CAN, as its wheel/1 file describes it.")
    ] = None,
    seconds: Annotated[float, option("S", "Device time to record.", min=0.0)] = float("inf"),
    fusion: Annotated[Path | None, option("FOLDER", "Also makes a fusion/1 folder, for `station locate`.")] = None,
    calibration: Annotated[Path | None, option("FILE", "For --fusion; else the unit's newest stored one.")] = None,
    lever_arm: Annotated[str, option("X,Y,Z", "For --fusion: IMU to antenna [m], IMU axes.")] = "",
    model: Model = "",
    serial: Serial = "",
    db: Database = None,
) -> None:
    """Record the raw bytes and the counts of a device; Ctrl-C stops and keeps the recording.

    The folder holds session_*.mcap with every byte since the port was opened, written by the reader process, and
    recording.mcap with bytes and counts of the requested seconds [s, device time]; both open in Foxglove. With
    --gnss also gnss_session_*.mcap (its bytes) and gnss_*.mcap (its fixes), and UTC with the rows. A fault of
    either device is reported on stderr when it begins and when it is over.

    With --camera also camera_session_*.mcap (its bytes: every image) and camera.toml, and with --fusion the tracks
    of features in its images.

    With --wheel also wheel_session_*.mcap (every frame of its bus), wheel.toml and wheel.dbc, and with --fusion
    its speeds: docs/how-to/locate-wheel.md.

    With --fusion, IMU (calibrated: rad/s, m/s2) and fixes (m East-North-Up of the first) are then written on one
    clock, with noise densities from the Allan deviation of the longest rest. `replay:FILE` with --fusion and
    without --out makes that folder from an existing recording of this command or of `station monitor`.

    Exit code 3 if there is no fix or no calibration for --fusion, or no sample in a replayed file, 4 if port or
    device fail, 130 on Ctrl-C.

    Example: station record serial:///dev/ttyUSB0?format=counts --seconds 60 --out r1
    """
    from drivers.addresses import whole_url

    url = whole_url(url)
    made = _fusion(url, out, fusion, calibration, lever_arm, model, serial, db)
    if out is None:
        made(url)
        return
    from drivers.errors import ReplayEnded
    from station.files.atomic_file import new_folder, recording_path
    from station.stream.camera import open_camera, read_description
    from station.stream.gnss_feed import open_gnss
    from station.stream.live.live_feed import no_recording, open_feed
    from station.stream.reader import Reader
    from station.stream.recorder import plain_recording
    from station.stream.sample_rate import SampleRate, host_sample_rate
    from station.stream.wheel import open_wheel
    from station.stream.wheel import read_description as read_wheel

    described = None if camera is None else read_description(camera)
    rolling = None if wheel is None else read_wheel(wheel)
    with ExitStack() as after, ExitStack() as stack:
        folder = stack.enter_context(new_folder(out, plain_recording.RECORDING_FILE))
        reader = stack.enter_context(Reader(url, recording_path(folder)))
        receiver = stack.enter_context(open_gnss(gnss, folder)) if gnss else None
        auxiliary = list["CameraFeed | WheelFeed"]()
        if described is not None:
            auxiliary.append(stack.enter_context(open_camera(described, folder)))
        if rolling is not None:
            auxiliary.append(stack.enter_context(open_wheel(rolling, folder)))
        feed = open_feed(reader)
        rate = SampleRate(feed, receiver.utc, receiver.utc_scatter) if receiver else host_sample_rate(feed)
        # also of what Ctrl-C or a fault has ended, once its files are closed
        after.callback(made, f"replay:{folder / plain_recording.RECORDING_FILE}?format={feed.wire.name}")
        try:
            done = plain_recording.record(feed, folder, seconds, receiver, _watch(feed, receiver, rate, auxiliary))
        except ReplayEnded as error:
            after.pop_all()
            (folder / plain_recording.RECORDING_FILE).unlink()  # so that nothing is left of the folder
            raise no_recording(error, feed.wire.name) from error
        finally:
            if (folder / plain_recording.RECORDING_FILE).exists():
                _say(out / plain_recording.RECORDING_FILE, feed, receiver, rate.text if receiver else "")
                for each in auxiliary:
                    typer.echo(each.summary)
        typer.echo(f"{done.seconds:.3f} s of device time, {plural(done.samples, 'sample')}")


def _watch(
    feed: "LiveFeed",
    receiver: "GnssFeed | None",
    rate: "SampleRate",
    auxiliary: "Sequence[CameraFeed | WheelFeed]",
) -> Callable[[], None]:
    """Return what reports faults of each device on stderr when they begin and when they are over."""
    from station.stream.live.stream_trouble import TroubleLog

    def log_of(name: str) -> TroubleLog:
        return TroubleLog(name, lambda text: typer.echo(text, err=True))

    line, sky = log_of(feed.address.name), log_of("" if receiver is None else receiver.address.name)
    logs = [(each, log_of(each.address.name)) for each in auxiliary]

    def look() -> None:
        line.look(feed.amiss or feed.silent or ("" if receiver else rate.warned()))
        if receiver is not None:
            warned = rate.warned()
            sky.look(receiver.trouble or warned)
        for each, log in logs:
            each.advance()
            log.look(each.trouble)

    return look


def _say(file: Path, feed: "LiveFeed", receiver: "GnssFeed | None", warning: str) -> None:
    """Say what was recorded, and what was met."""
    counters, framing = feed.stream.counters, feed.stream.decoder.counters
    typer.echo(
        f"{file}: {plural(counters.samples, 'sample')} of {feed.wire.name}, "
        f"{plural(counters.breaks, 'break')} ({plural(counters.lost, 'frame')} lost), "
        f"{counters.repeated} repeated, {plural(counters.restarts, 'restart')}, "
        f"{plural(feed.losses, 'gap')} (port lost), "
        f"{framing.bad_crc} bad check, {plural(framing.skipped_bytes, 'byte')} in no frame"
    )
    if zeros := feed.stream.decoder.kind.zeros:
        typer.echo(f"{feed.wire.name} does not measure {', '.join(zeros)}: 0 stands there")
    if receiver is not None:
        typer.echo(receiver.summary)
    if warning:
        typer.echo(f"warning: {warning}", err=True)


def _fusion(
    url: str, out: Path | None, fusion: Path | None, calibration: Path | None, lever_arm: str, model: str,
    serial: str, db: str | None,
) -> Callable[[str], None]:  # fmt: skip
    """Return what makes the fusion folder of a recording's URL, if one is wanted."""
    if out is None and (fusion is None or not url.startswith("replay:")):
        raise typer.BadParameter("a folder to record into; expected --out FOLDER", param_hint="--out")
    if fusion is None:
        return lambda recording: None
    where = fusion
    from station.locate.folder_from_recording import FusionOptions, fusion_from_recording

    with refused_as("--lever-arm"):
        arm = lengths(lever_arm)
    asked = FusionOptions(calibration, db, arm, model, serial)

    def make(recording: str) -> None:
        for line in fusion_from_recording(recording, where, asked):
            typer.echo(line)

    return make
