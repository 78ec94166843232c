"""``station simulate``: a simulated IMU on a real transport, and its truth as a file."""

import contextlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.addresses import host_and_port
from station.commands import Database
from station.commands._options import end_on_signals, flag, option

if TYPE_CHECKING:
    from drivers.simulated.companions.camera_server import SimulatedCamera
    from drivers.simulated.companions.gnss_server import SimulatedGnss
    from drivers.simulated.faults import TimedFault
    from drivers.simulated.server import SimulatedDevice
    from drivers.simulated.truth import Truth
    from drivers.simulated.vehicle_track import VehicleTrack


def read_truth(path: Path) -> "Truth":
    """Read a truth; raise `DataRefused` if it is none."""
    from drivers.simulated.truth import load_truth

    with blamed_on(path):
        return load_truth(read_text(path))


@contextlib.contextmanager
def blamed_on(file: Path | None) -> Iterator[None]:
    """Have what the simulator refuses name the file it came from."""
    from drivers.errors import SimulatorError, TruthRefused, UnknownEffect
    from station.errors import DataRefused

    try:
        yield
    except TruthRefused as error:
        raise DataRefused(file or "truth", None, error.found, error.expected) from error
    except UnknownEffect as error:
        accepted = f"one of {', '.join(error.accepted)}"
        raise DataRefused(file or "truth", None, f"effect {error.name!r}", accepted) from error
    except SimulatorError as error:
        raise DataRefused(file or "truth", None, str(error), "it as described") from error


def read_text(path: Path, kind: str = "a TOML file") -> str:
    """Return what a file says; raise `DataRefused` if it cannot be read."""
    from station.errors import DataRefused

    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataRefused(path, None, f"no readable file ({error})", f"{kind} in UTF-8") from error


def simulate(
    context: typer.Context,
    scenario: Annotated[Path | None, option("TOML", "A whole bench in a file; see below.")] = None,
    truth: Annotated[Path | None, option("TOML", "True values of the unit and its bench.")] = None,
    example: Annotated[int | None, option("SEED", "A random unit instead.")] = None,
    effect: Annotated[
        list[Path] | None, option("FILE", "An error term (effect/1) with sizes in the truth; repeatable.")
    ] = None,
    latitude: Annotated[float | None, option("DEG", "Its latitude.", min=-90, max=90)] = None,
    height: Annotated[float | None, option("M", "Above the ellipsoid.", min=-1000, max=20000)] = None,
    format: Annotated[str, option("", "Wire format.")] = "counts",
    pty: Annotated[Path | None, option("LINK", "Keep this path pointing at the pty.")] = None,
    tcp: Annotated[
        int | None, option("PORT", "Serve on this loopback port instead; 0: any.", min=0, max=65535)
    ] = None,
    transport: Annotated[
        str | None, option("", "pty, tcp, or CAN: slcan (an adapter on a pty), udp_multicast.")
    ] = None,
    dbc: Annotated[str, option("DBC", "Frames on CAN; the station's own else.")] = "",
    mapping: Annotated[str, option("TOML", "What the DBC's signals are.", names="--map")] = "",
    control: Annotated[int, option("PORT", "Port of the hands; 0: any.", min=0, max=65535)] = 0,
    speed: Annotated[float, option("N", "Device seconds per second; 0: as fast as read.")] = 1.0,
    seed: Annotated[int, option("", "Seed of noise, hands and faults.")] = 1,
    faults: Annotated[Path | None, option("TOML", "[[fault]] tables: kind, at_s, every_s ...")] = None,
    gnss: Annotated[
        str | None, option("LINK", "Also an autopilot: udp[:PORT], udpto:HOST:PORT, tcp[:PORT], pty[:PATH].")
    ] = None,
    track: Annotated[Path | None, option("CSV", "Where both go: t_s,e_m,n_m,u_m. Else they stand.")] = None,
    camera_file: Annotated[Path | None, option("FILE", "Describe a scenario's camera here, camera/1.")] = None,
    wheel_file: Annotated[Path | None, option("FILE", "Also a wheel on CAN, described here, wheel/1.")] = None,
    pps: Annotated[
        bool, flag("--pps", "A pulse per second, reported in its frames: --format stim300 or a NovAtel log.")
    ] = False,
    hold: Annotated[bool, flag("--hold", "Start when the hands send go.")] = False,
    db: Database = None,
) -> None:
    """Serve a simulated IMU in its cube until Ctrl-C; prints its URL and the control address of its hands.

    Gravity is the normal gravity of its latitude and height unless the truth states another; the line `site` has
    the options for `station calibrate`. Scale factors in a truth are in count/(g s) and count/deg, biases in g and
    deg/s, tilts in rad, times in s. The hands accept lines such as `place 3 45`, `turn x + 3 5`, `rest 10`,
    `time`, `status` over TCP. With --gnss there is also an autopilot with a GNSS receiver, with the same truth and
    clock; its faults are [[gnss_fault]]. With --wheel-file a wheel's speed along --track is on a CAN bus of its
    own, 1.5 % too low; FILE is for `station monitor --wheel`.

    On CAN the URL contains the sample period; `--transport slcan --pty LINK` keeps a link to the adapter.

    With --scenario one file describes everything, including timed moves of the operator and faults; events are
    printed when they happen: docs/how-to/testing.md. Only --speed and --camera-file can be added.

    Exit code 3 if the truth, the faults or the scenario are wrong, 4 if the port cannot be made.

    Example: station simulate --example 7 --pty /tmp/imu --speed 20
    """
    from drivers.errors import PortNotFound
    from drivers.simulated.server import CAN_TRANSPORTS, SimulatedDevice, serve
    from drivers.simulated.truth import Truth, truth_from
    from drivers.simulated.vehicle_track import load_track
    from drivers.wire import FORMATS
    from station.files.scenario_schema import read_faults

    if scenario is not None:
        _serve_scenario(scenario, context, camera_file)
        return
    if camera_file is not None:
        raise typer.BadParameter(
            "a camera stands in a scenario; expected with --scenario", param_hint="--camera-file"
        )
    if truth is not None and example is not None:
        raise typer.BadParameter("--truth and --example are two truths; expected one of them")
    if pty is not None and tcp is not None:
        raise typer.BadParameter("--pty and --tcp are two transports; expected one of them")
    transport = transport or ("pty" if tcp is None else "tcp")
    has_format = str(context.get_parameter_source("format")).endswith("COMMANDLINE")
    _check_transport(transport, is_tcp=tcp is not None, has_format=has_format, has_messages=bool(dbc or mapping))
    if format not in FORMATS:
        raise typer.BadParameter(f"format {format!r}: expected one of {', '.join(FORMATS)}")
    if not speed >= 0:
        raise typer.BadParameter(f"speed {speed:g}: expected 0 or more")
    unit = read_truth(truth) if truth is not None else Truth.example(seed if example is None else example)
    unit = replace(unit, terms={**unit.terms, **_terms(effect or [], unit, truth)})
    place = {"latitude_deg": latitude, "height_m": height}
    unit = truth_from({name: value for name, value in place.items() if value is not None}, unit)
    with blamed_on(track):
        path = load_track(read_text(track, "a CSV file")) if track is not None else None
    is_on_can = transport in CAN_TRANSPORTS
    planted, of_gnss = read_faults(faults, is_on_can=is_on_can) if faults is not None else ((), ())
    autopilot = _autopilot(gnss, path, of_gnss)
    with blamed_on(truth):
        device = SimulatedDevice(
            unit, seed, format, speed,
            transport=transport, link=pty, port=tcp or 0, control_port=control,
            faults=planted, hold=hold, dbc=dbc, mapping=mapping, pps=pps,
        )  # fmt: skip
    with blamed_on(track):
        if path is not None:
            device.device.drive(path)
    end_on_signals()
    try:
        with ExitStack() as stack, blamed_on(truth):
            serve(device, partial(_announce_all, stack, autopilot, path, wheel_file))
    except OSError as error:
        reason = (error.strerror or str(error)).partition(";")[0]
        raise PortNotFound(str(pty or tcp or "pty"), reason, "choose another path or port") from error


def _check_transport(transport: str, *, is_tcp: bool, has_format: bool, has_messages: bool) -> None:
    """Raise `typer.BadParameter` if the transport is unknown, or the options for it belong to another."""
    from drivers.simulated.server import CAN_TRANSPORTS, TRANSPORTS

    if transport not in TRANSPORTS or is_tcp != (transport == "tcp"):
        raise typer.BadParameter(
            f"transport {transport!r}: expected one of {', '.join(TRANSPORTS)}, tcp with --tcp"
        )
    if transport in CAN_TRANSPORTS and has_format:
        raise typer.BadParameter(f"--format and --transport {transport}; on CAN expected --dbc and --map instead")
    if has_messages and transport not in CAN_TRANSPORTS:
        raise typer.BadParameter(f"--dbc or --map; expected with --transport {' or '.join(CAN_TRANSPORTS)} only")


def _serve_scenario(path: Path, context: typer.Context, camera_file: Path | None) -> None:
    from drivers.errors import PortNotFound
    from station.files.scenario import read_scenario, serve_scenario

    given = {name for name in context.params if str(context.get_parameter_source(name)).endswith("COMMANDLINE")}
    if other := sorted(given - {"scenario", "speed", "camera_file", "db"}):
        raise typer.BadParameter(f"--{other[0]} and --scenario; expected it in the scenario's file")
    scenario = read_scenario(path)
    if camera_file is not None and scenario.camera is None:
        raise typer.BadParameter(f"no [camera] in {path}", param_hint="--camera-file")
    end_on_signals()
    try:
        with contextlib.suppress(KeyboardInterrupt):
            serve_scenario(
                scenario,
                partial(_announce, camera_file=camera_file),
                lambda line: typer.echo(line, err=True),
                context.params["speed"] if "speed" in given else None,
            )
    except OSError as error:
        raise PortNotFound(str(path), str(error), "choose another link or port in it") from error


def _autopilot(
    where: str | None, path: "VehicleTrack | None", planted: "tuple[TimedFault, ...]"
) -> "Callable[[SimulatedDevice], SimulatedGnss] | None":
    """Return what makes the autopilot once the IMU is served, None where none is wanted."""
    from drivers.simulated.companions.gnss_server import SimulatedGnss

    if where is None:
        return None
    transport, _, rest = where.partition(":")
    peer, port, link = None, 0, None
    match transport:
        case "udp" | "tcp" if not rest or (rest.isdecimal() and int(rest) < 65536):
            port = int(rest or 0)
        case "udpto" if (peer := host_and_port(rest)) is not None and _is_host(peer[0]):
            port = peer[1]
        case "pty":
            link = Path(rest) if rest else None
        case _:
            raise typer.BadParameter(
                f"gnss {where!r}: expected udp[:PORT], udpto:HOST:PORT, tcp[:PORT] or pty[:PATH]"
            )
    return lambda device: SimulatedGnss(
        device.truth, faults=planted, track=path, seed=device.seed, imu=device,
        transport=transport.removesuffix("to"), port=port, link=link, to=peer,
    )  # fmt: skip


def _is_host(name: str) -> bool:
    import socket

    try:
        return bool(name) and bool(socket.getaddrinfo(name, None, socket.AF_INET))
    except (OSError, UnicodeError):
        return False


def _announce_all(
    stack: ExitStack, autopilot: "Callable[[SimulatedDevice], SimulatedGnss] | None", path: "VehicleTrack | None",
    wheel_file: Path | None, device: "SimulatedDevice",
) -> None:  # fmt: skip
    """Serve what goes with a device, and say where all of it is."""
    if wheel_file is not None:
        from drivers.simulated.companions.wheel_on_can import DBC, SimulatedWheel, wheel_toml
        from station.files.atomic_file import replace_file

        wheel = stack.enter_context(SimulatedWheel(path, seed=device.seed, imu=device))
        replace_file(wheel_file, wheel_toml(wheel.url, DBC).encode())
        typer.echo(f"wheel {wheel.url}")
    _announce(device, stack.enter_context(autopilot(device)) if autopilot else None)


def _announce(
    device: "SimulatedDevice", gnss: "SimulatedGnss | None", camera: "SimulatedCamera | None" = None,
    camera_file: Path | None = None,
) -> None:  # fmt: skip
    typer.echo(f"url {device.url}")
    if gnss is not None:
        typer.echo(f"gnss {gnss.url}")
    if camera is not None:
        typer.echo(f"camera {camera.url}")
        if camera_file is not None:
            from drivers.simulated.companions.truths import camera_toml
            from station.files.atomic_file import replace_file

            replace_file(camera_file, camera_toml(camera.camera, camera.url).encode())
    truth = device.truth
    height = f" --height {truth.height_m:g}" if truth.height_m else ""  # as `station calibrate` takes it
    typer.echo(f"site --latitude {truth.latitude_deg:g}{height} --gravity {truth.local_gravity:.6f}")
    typer.echo(f"control {device.control}")
    typer.echo(f"serving {device.truth.model} {device.truth.serial}; Ctrl-C ends it", err=True)
    if gnss is not None or camera is not None:
        others = [name for name, each in (("the receiver", gnss), ("the camera", camera)) if each is not None]
        send = "sends" if len(others) == 1 else "send"
        typer.echo(f"one clock for all: {' and '.join(others)} {send} only while the IMU is read", err=True)


def _terms(files: list[Path], unit: "Truth", truth: Path | None) -> dict[str, str]:
    """Return the text of each effect by its name.

    What cannot be planted is refused under its own file, and a truth that does not have its sizes.
    """
    from drivers.simulated.effects.written_term import planted_term
    from station.errors import DataRefused
    from station.files.effect_file import each_once, read_effect

    read = [(path, read_effect(path)) for path in files]
    for path, one in read:
        with blamed_on(path):
            planted_term(one.name, one.text)
        if one.name not in unit.effects:
            expected = f'[effects."{one.name}"] with {", ".join((*one.term.coefficients, *one.term.parameters))}'
            raise DataRefused(
                truth or "truth", None, f"no sizes of {one.name}", expected, "add it to --truth FILE"
            )
    return {one.name: one.text for one in each_once(read)}
