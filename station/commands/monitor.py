"""``station monitor`` and ``reset-terminal``: roll and pitch of a live device; a terminal restored."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database, _options
from station.commands._options import argument, flag, lengths, option, refused_as

AIDS = ("none", "gnss", "airspeed", "airspeed-filter")  # the last two are one


def monitor(
    url: Annotated[str, argument("URL", "The IMU, as in serial:///dev/ttyUSB0; or replay:FILE.mcap.")],
    gnss: _options.Gnss = "",
    aid: Annotated[str, option("AID", "none, gnss or airspeed; gnss with --gnss; in a replay as it was.")] = "",
    filter: Annotated[
        str,
        option(
            "FILTERS", "joint, mixer, paper, paper-filter, paper-whole; two: joint,paper.", names="--filter --law"
        ),
    ] = "",
    tau: Annotated[
        float | None, option("S", "Time constant of the complementary filters; else K1 0.08, K2 0.0125.", min=0.1)
    ] = None,
    locate: Annotated[bool, flag("--locate", "Also position and heading.")] = False,
    lever_arm: Annotated[str, option("X,Y,Z", "For --locate: IMU to antenna [m], IMU axes.")] = "",
    camera: Annotated[Path | None, option("FILE", "For --locate: a camera/1 file; extra `camera`.")] = None,
    wheel: Annotated[Path | None, option("FILE", "For --locate: a wheel/1 file, a speed on CAN.")] = None,
    calibration: Annotated[
        Path | None, option("FILE", "A calibration.json; else the unit's newest stored one.")
    ] = None,
    axes: _options.Axes = "x,-y,-z",
    latitude: _options.Latitude = None,
    heading: _options.Heading = None,
    gravity: Annotated[float | None, option("M/S2", "Surveyed; else normal.", min=9.7, max=9.9)] = None,
    alarm: Annotated[
        list[str] | None, option("NAME=LIMIT", "Alarm above: roll, pitch, rate, sigma, residual ...")
    ] = None,
    folder: Annotated[Path | None, option("FOLDER", "A new folder for the recording.")] = None,
    record: Annotated[bool, flag("--record/--no-record", "Record from the start, or when r is pressed.")] = True,
    plain: _options.Plain = False,
    json: Annotated[bool, flag("--json", "A line of monitor/1 for each tenth of a second.")] = False,
    mavlink_out: Annotated[str, option("LINK", "Sends ATTITUDE, as to udpout:127.0.0.1:14551.")] = "",
    stream: Annotated[list[str] | None, option("OUTPUT", "Also stream samples, as `station stream --to`.")] = None,
    seconds: _options.Seconds = float("inf"),
    speed: _options.Speed = 1.0,
    model: _options.Model = "",
    serial: _options.Serial = "",
    slow: _options.Slow = False,
    quiet: _options.Quiet = False,
    db: Database = None,
) -> None:
    """Show roll and pitch [deg] of a live IMU, and its errors at rest with and without the calibration.

    Angles are of forward-right-down axes, rates in deg/s. The run is recorded: session_*.mcap has every byte,
    recording.mcap bytes and counts, events.csv marks and alarms; `replay:FILE` gives the same attitude again. Keys
    of the screen: m mark, r record, z zero (display only), n restart charts, q leave.

    --filter uses another filter than the joint Kalman filter, or two side by side: mixer and paper are the
    complementary filters of You and Lee, with the forward speed of a receiver or autopilot (paper-filter: their
    velocity filter; paper-whole: also velocity changes). Their readings are in laws.csv and in --json.

    --locate adds position [m, East-North-Up of the first fix] and true heading [deg] with uncertainties, from IMU
    and GNSS; with --camera also from a camera (its file: docs/how-to/locate-vision.md), with --wheel from a
    vehicle's speed over CAN (docs/how-to/locate-wheel.md).

    Exit code 2 if the disk cannot be written or an extra is missing, 3 if there is no calibration, 4 if the port
    cannot be opened, 130 on Ctrl-C.

    Example: station monitor serial:///dev/ttyUSB0?format=counts --latitude 48.1 --alarm roll=10
    """
    import sys

    from drivers.address_parsing import parse_device_url
    from drivers.addresses import whole_url
    from drivers.errors import PortNotFound
    from procedures.attitude.filter_choice import JOINT, parse_filters, refuse_without_velocity
    from station.calibrated.output_frame import body_axes
    from station.monitor.monitor_command import MonitorRequest, run
    from station.monitor.view import parse_alarm
    from station.sending.outputs import kind_of
    from station.tui import run_monitor

    url = whole_url(url)
    if json and plain:
        raise typer.BadParameter("--json and --plain are two outputs; expected one of them")
    _check_sources(aid, locate, camera, wheel, has_receiver=bool(gnss) or url.startswith("replay:"))
    aid = "airspeed-filter" if aid == "airspeed" else aid
    with refused_as("--filter"):
        filters = parse_filters(filter) if filter else ()
        if filters and not url.startswith("replay:"):
            refuse_without_velocity(filters, aid or ("gnss" if gnss else "none"))
    with refused_as("--lever-arm"):
        arm = lengths(lever_arm)
    with refused_as("--alarm"):
        alarms = tuple(parse_alarm(text) for text in alarm or ())
    if filters and filters[0] != JOINT and any(each.name == "sigma" for each in alarms):
        raise typer.BadParameter(f"filter {filters[0]} has no uncertainty; name joint first", param_hint="--alarm")
    for text in stream or ():
        if kind_of(text).scheme == "stdout":
            raise typer.BadParameter("stdout has the monitor's own lines; expected another", param_hint="--stream")
    with refused_as("--axes"):
        C = body_axes(axes)
    address = parse_device_url(url)
    if address.scheme == "replay" and not Path(address.path).exists():
        raise PortNotFound(address.path, "no such file", "check the file's name")
    if not (json or plain) and not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise typer.BadParameter("the screen needs a terminal; --plain writes lines of text, --json lines of JSON")
    wanted = MonitorRequest(
        url=url, C=C, aid=aid, gnss=gnss, mavlink_out=mavlink_out, calibration=calibration, latitude_deg=latitude,
        heading_deg=heading, gravity=gravity, alarms=alarms, folder=folder, records=record, seconds=seconds,
        speed=speed, model=model, serial=serial, database=db, locate=locate, lever_arm=arm,
        camera=camera, wheel=wheel, filters=filters, tau_s=tau, stream=tuple(stream or ()),
    )  # fmt: skip
    show = partial(run_monitor, slow=slow, quiet=quiet)
    run(wanted, "json" if json else "plain" if plain else "screen", show, quiet=quiet)


# Each undoes one thing that a screen asks a terminal for; a terminal that does not know one ignores it.
ALTERNATE_SCREEN, HIDDEN_CURSOR, PASTE, FOCUS, RESIZE, AT_ONCE = "?1049", "?25", "?2004", "?1004", "?2048", "?2026"
MOUSE = ("?1000", "?1002", "?1003", "?1006", "?1015", "?1016")
OFF = (*MOUSE, PASTE, FOCUS, RESIZE, AT_ONCE, ALTERNATE_SCREEN)
KEYBOARD, PLAIN_LETTERS = "\x1b[<u", "\x1b[0m"
RESET = "".join(f"\x1b[{mode}l" for mode in OFF) + f"\x1b[{HIDDEN_CURSOR}h{KEYBOARD}{PLAIN_LETTERS}"


def _check_sources(aid: str, locate: bool, camera: Path | None, wheel: Path | None, *, has_receiver: bool) -> None:
    """Raise `typer.BadParameter` if an option needs a source that no other option names."""
    if aid and aid not in AIDS:
        raise typer.BadParameter(f"found {aid!r}, expected one of {', '.join(AIDS)}", param_hint="--aid")
    if aid not in {"", "none"} and not has_receiver:
        raise typer.BadParameter(f"{aid} needs a source: give --gnss URL", param_hint="--aid")
    if locate and not has_receiver:
        raise typer.BadParameter("locating needs a receiver: give --gnss URL", param_hint="--locate")
    if camera is not None and not locate:
        raise typer.BadParameter("a camera is for locating: give --locate", param_hint="--camera")
    if wheel is not None and not locate:
        raise typer.BadParameter("a wheel is for locating: give --locate", param_hint="--wheel")


def reset_terminal(db: Database = None) -> None:
    """Restore a terminal after a screen of the station was killed: its own screen, cursor, mouse and echo.

    It does no harm to a terminal that works. --db, which every command has, is not used.

    Exit code 2 if there is no terminal.

    Example: station reset-terminal
    """
    import subprocess
    import sys

    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise typer.BadParameter("this is no terminal; type it in the one that is to be restored")
    sys.stdout.write(RESET)
    sys.stdout.flush()
    subprocess.run(["stty", "sane"], check=False)
    typer.echo("the terminal is restored; `station resume` goes on with a campaign that was under way")
