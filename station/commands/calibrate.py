"""``station calibrate``: a live device to a calibration, guided."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._guided import (
    Hands,
    Headless,
    MoveS,
    Plain,
    Quiet,
    Slow,
    Store,
    Tremor,
    WarmUp,
    Web,
    WebPort,
)
from station.commands._options import option, refused_as


def calibrate(
    device: Annotated[str, option("--device", "URL", "The IMU, as in serial:///dev/ttyUSB0.")] = "",
    out: Annotated[Path | None, option("--out", "FOLDER", "A new folder for the campaign.")] = None,
    gnss: Annotated[str, option("--gnss", "URL", "A GNSS receiver, as in mavlink:udpin:0.0.0.0:14550.")] = "",
    latitude: Annotated[float | None, option("--latitude", "DEG", "Geodetic latitude of the slab.")] = None,
    longitude: Annotated[float | None, option("--longitude", "DEG", "")] = None,
    height: Annotated[float | None, option("--height", "M", "Above the ellipsoid.")] = None,
    gravity: Annotated[float | None, option("--gravity", "M/S2", "Surveyed gravity; else the normal one.")] = None,
    gravity_std: Annotated[float | None, option("--gravity-std", "M/S2", "Its 1 sigma.")] = None,
    cube: Annotated[str | None, option("--cube", "ID", "The cube, see `fixtures`.")] = None,
    slab: Annotated[str | None, option("--slab", "ID", "The slab, see `fixtures`.")] = None,
    operator: Annotated[str | None, option("--operator", "", "Who calibrates.")] = None,
    dwell_s: Annotated[
        float | None, option("--dwell-s", "S", "Accepted seconds per position; 0: from --bias-ug.", min=0.0)
    ] = None,
    bias_ug: Annotated[
        float | None, option("--bias-ug", "UG", "1 sigma wanted of the accelerometer biases.")
    ] = None,
    turns: Annotated[int | None, option("--turns", "N", "Revolutions per hand turn.", min=1)] = None,
    repeats: Annotated[
        int | None,
        option("--repeats", "N", "How often the first position comes again at the end; else 1.", min=0, max=9),
    ] = None,
    heading_std: Annotated[
        float | None, option("--heading-std", "DEG", "How well headings are set, 1 sigma.")
    ] = None,
    closure_std: Annotated[float | None, option("--closure-std", "DEG", "How well turns close, 1 sigma.")] = None,
    model: Annotated[str | None, option("--model", "", "For a device that does not send its own.")] = None,
    serial: Annotated[str | None, option("--serial", "", "For a device that does not send its own.")] = None,
    plan: Annotated[Path | None, option("--plan", "FILE", "Other steps than the usual ones, as plan/1.")] = None,
    until_limits: Annotated[
        bool, option("--until-limits", "", "Ask for what brings most, until the model's limits can be judged.")
    ] = False,
    sigma: Annotated[
        list[str] | None,
        option("--sigma", "NAME=SIGMA", "The same until a 1 sigma is reached, as in `plan`; repeatable."),
    ] = None,
    noise: Annotated[
        list[Path] | None, option("--noise", "CAMPAIGN", "A campaign of the unit that says its noise; repeatable.")
    ] = None,
    warm_up: WarmUp = True,
    headless: Headless = False,
    store: Store = False,
    plain: Plain = False,
    web: Web = False,
    port: WebPort = 8000,
    slow: Slow = False,
    quiet: Quiet = False,
    hands: Hands = None,
    move_s: MoveS = 45.0,
    tremor: Tremor = False,
    db: Database = None,
) -> None:
    """Guide a technician through 12 positions, 6 hand turns and the first position again to a verdict.

    Without options the screen asks for what it needs; with --device and --latitude it begins at once. The counts
    say which face is up and whether the cube rests; every accepted step is on the disk and in the database
    before it is said to be. After a kill or a break `station resume` continues it. In the folder: campaign.toml
    with a data file per step, the raw bytes, solution.json, report.html and, once stored, calibration.json.
    Dwells are in seconds of device time, angles in deg. With --gnss latitude, longitude and height come from
    averaged fixes where they are not given, rows hold UTC, and the sample rate is checked against it.

    With --until-limits or --sigma the plan is not fixed: after each placing the one is asked for that brings it on
    soonest, a dwell ends when more of it does not pay, and it is over when every sigma is met that --sigma or the
    limits' guard bands ask for; the screen says how far each is. It needs the unit's noise, from its campaigns in
    the database, else its model's, else --noise. `g` at the verdict goes on.

    Exit code 1 if the verdict is FAIL, 2 if the disk refuses, 3 if the sample rate is over 1 % off GNSS time,
    4 if port or device fail, 130 if cancelled.

    Example: station calibrate --device serial:///dev/ttyUSB0?format=counts --latitude 48.1
    """
    from station.commands._guided import Display, campaigns_root, guide, set_up
    from station.files.setup import Setup
    from station.guide.command import OperatorCommand
    from station.guide.last_setup import load_setup
    from station.guide.start_engine import EngineOptions

    given = {
        "url": device, "gnss": gnss, "folder": str(out) if out else "",
        "latitude_deg": latitude, "longitude_deg": longitude, "height_m": height,
        "gravity_m_s2": gravity, "gravity_std_m_s2": gravity_std, "cube": cube, "slab": slab,
        "operator": operator, "dwell_s": dwell_s, "bias_ug": bias_ug, "revolutions": turns, "repeats": repeats,
        "heading_std_deg": heading_std, "closure_std_deg": closure_std, "model": model, "serial": serial,
    }  # fmt: skip
    begins = bool(device) and (latitude is not None or bool(gnss))
    if (headless or plain) and not begins:
        raise typer.BadParameter("without a screen, give at least --device and --latitude or --gnss")
    if store and not headless:
        raise typer.BadParameter("--store is for --headless; on a screen the operator stores with s")
    _refuse_contradicting(
        until_limits, sigma or [], noise, {"--plan": plan, "--dwell-s": dwell_s, "--bias-ug": bias_ug,
                                           "--turns": turns, "--repeats": repeats},
    )  # fmt: skip
    setup = set_up(Setup() if begins else load_setup(), given)
    options = EngineOptions(
        root=campaigns_root(), database=db, setup=setup, plan=plan, hands=hands, move_s=move_s, tremor=tremor,
        until_limits=until_limits, sigma=tuple(sigma or ()), noise=tuple(each.resolve() for each in noise or ()),
        asks=not headless, warms_up=not headless and warm_up,
        first=OperatorCommand(verb="begin", setup=setup) if begins else None,
    )  # fmt: skip
    screen = Display(headless=headless, plain=plain, web=web, port=port, slow=slow, quiet=quiet, stores=store)
    raise typer.Exit(guide(options, screen))


def _refuse_contradicting(
    until_limits: bool, sigma: list[str], noise: list[Path] | None, fixed: dict[str, object]
) -> None:
    """Refuse options of a fixed plan beside those of one that is not, and sigmas that cannot be read."""
    if not (until_limits or sigma):
        if noise:
            raise typer.BadParameter("it is for --until-limits or --sigma", param_hint="--noise")
        return
    if given := [name for name, value in fixed.items() if value is not None]:
        raise typer.BadParameter(
            f"the plan is not fixed with --until-limits or --sigma: leave {', '.join(given)} out"
        )
    from station.results.planning.wanted_by_limits import wanted_by_name

    with refused_as("--sigma"):
        wanted_by_name(sigma)
