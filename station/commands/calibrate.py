"""``station calibrate`` and ``resume``: a live device to a calibration, guided step by step."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._guided import GuideOptions, guide, set_up
from station.commands._options import Gnss, Noise, argument, flag, option, refused_as


@dataclass(frozen=True, slots=True)
class SetupOptions:
    """The options of a set-up, by the names of its fields."""

    url: Annotated[str, option("URL", "The IMU, as in serial:///dev/ttyUSB0.", "--device")] = ""
    folder: Annotated[str, option("FOLDER", "A new folder for the campaign.", "--out")] = ""
    gnss: Gnss = ""
    latitude_deg: Annotated[
        float | None, option("DEG", "Geodetic latitude of the surface plate.", "--latitude")
    ] = None
    longitude_deg: Annotated[float | None, option("DEG", "", "--longitude")] = None
    height_m: Annotated[float | None, option("M", "Above the ellipsoid.", "--height")] = None
    gravity_m_s2: Annotated[
        float | None, option("M/S2", "Surveyed gravity; else the normal one.", "--gravity")
    ] = None
    gravity_std_m_s2: Annotated[float | None, option("M/S2", "Its standard uncertainty.", "--gravity-std")] = None
    cube: Annotated[str | None, option("ID", "The cube, see `fixtures`.")] = None
    slab: Annotated[str | None, option("ID", "The surface plate, see `fixtures`.")] = None
    operator: Annotated[str | None, option("", "Who calibrates.")] = None
    dwell_s: Annotated[float | None, option("S", "Accepted seconds per position; 0: from --bias-ug.", min=0.0)] = (
        None
    )
    bias_ug: Annotated[float | None, option("UG", "Target for the uncertainty of accelerometer biases.")] = None
    revolutions: Annotated[int | None, option("N", "Revolutions per manual rotation.", "--turns", min=1)] = None
    repeats: Annotated[
        int | None, option("N", "How often the first position is repeated at the end; else 1.", min=0, max=9)
    ] = None
    heading_std_deg: Annotated[
        float | None, option("DEG", "Standard uncertainty of headings.", "--heading-std")
    ] = None
    closure_std_deg: Annotated[
        float | None, option("DEG", "Standard uncertainty of the closure error of rotations.", "--closure-std")
    ] = None
    model: Annotated[str | None, option("", "For a device that does not send its own.")] = None
    serial: Annotated[str | None, option("", "For a device that does not send its own.")] = None


def calibrate(
    *,
    given: SetupOptions,
    plan: Annotated[Path | None, option("FILE", "Steps of a plan/1 instead of the usual ones.")] = None,
    until_limits: Annotated[
        bool, flag("--until-limits", "Ask for the most useful positions until a verdict is possible.")
    ] = False,
    sigma: Annotated[
        list[str] | None,
        option("NAME=SIGMA", "The same until an uncertainty is reached, as in `plan`; repeatable."),
    ] = None,
    noise: Noise = None,
    screen: GuideOptions,
    db: Database = None,
) -> None:
    """Guide a technician through 12 positions, 6 manual rotations and the first position again to a verdict.

    Without options the screen asks for what it needs; with --device and --latitude it starts at once. The station
    recognises from the sensor data which face is up and whether the cube rests. A step is reported as accepted
    only after it is on disk and in the database. After a crash or an interruption `station resume` continues. The
    folder holds campaign.toml with a data file per step, the raw bytes, solution.json, report.html and, once
    stored, calibration.json. Dwells are in seconds of device time, angles in deg. With --gnss, latitude, longitude
    and height come from averaged fixes if they are not given, rows hold UTC, and the sample rate is checked
    against UTC.

    With --until-limits or --sigma the plan is not fixed: after each position the station asks for the one that
    reduces uncertainty fastest; a dwell ends when more data would not help. The campaign is complete when every
    uncertainty is reached that --sigma or the limits' guard bands need; the screen shows the progress. This needs
    the unit's noise: from its campaigns in the database, else from its model's, else from --noise. Press `g` at
    the verdict to continue.

    Exit code 1 if the verdict is FAIL, 2 if the disk cannot be written, 3 if the sample rate is over 1 % off GNSS
    time, 4 if port or device fail, 130 if cancelled.

    Example: station calibrate --device serial:///dev/ttyUSB0?format=counts --latitude 48.1
    """
    from station.files.campaign_setup import Setup
    from station.guide.options import TargetUncertainties, load_setup
    from station.guide.view import OperatorCommand

    begins = bool(given.url) and (given.latitude_deg is not None or bool(given.gnss))
    if (screen.headless or screen.plain) and not begins:
        raise typer.BadParameter("without a screen, give at least --device and --latitude or --gnss")
    if screen.store and not screen.headless:
        raise typer.BadParameter("--store is for --headless; on a screen the operator stores with s")
    fixed: dict[str, object] = {"--plan": plan, "--dwell-s": given.dwell_s, "--bias-ug": given.bias_ug,
                                "--turns": given.revolutions, "--repeats": given.repeats}  # fmt: skip
    _refuse_contradicting(until_limits, sigma or [], noise, fixed)
    setup = set_up(Setup() if begins else load_setup(), asdict(given))
    files = tuple(each.resolve() for each in noise or ())
    targets = TargetUncertainties(limits=until_limits, sigma=tuple(sigma or ()), noise=files)
    options = screen.engine(
        db, setup, plan=plan, wanted=targets if until_limits or sigma else None,
        first=OperatorCommand(verb="begin", setup=setup) if begins else None,
    )  # fmt: skip
    raise typer.Exit(guide(options, screen))


def _refuse_contradicting(
    until_limits: bool, sigma: list[str], noise: list[Path] | None, fixed: dict[str, object]
) -> None:
    """Refuse options of a fixed plan together with those of one that is not, and sigmas that cannot be read."""
    if not (until_limits or sigma):
        if noise:
            raise typer.BadParameter("it is for --until-limits or --sigma", param_hint="--noise")
        return
    if given := [name for name, value in fixed.items() if value is not None]:
        raise typer.BadParameter(f"the plan is not fixed with --until-limits or --sigma: omit {', '.join(given)}")
    from station.results.plan_inputs import wanted_by_name

    with refused_as("--sigma"):
        wanted_by_name(sigma)


def resume(
    folder: Annotated[
        Path | None, argument("[FOLDER]", "The campaign's folder; else the newest unfinished.")
    ] = None,
    device: Annotated[str, option("URL", "Where the IMU is now, if not at the port it had.")] = "",
    list_only: Annotated[bool, flag("--list", "List the unfinished campaigns.")] = False,
    *,
    screen: GuideOptions,
    db: Database = None,
) -> None:
    """Resume an unfinished campaign on the same IMU.

    All accepted steps are kept. The unit is recognised by its serial number, or by its rates and noise; then the
    station asks for confirmation. The solution is identical to that of an uninterrupted campaign.

    Exit codes as `calibrate`; 3 if there is nothing to resume or its files were changed.

    Example: station resume --list
    """
    from fixtures_db.database import open_db
    from station.errors import DataRefused
    from station.guide.options import load_setup
    from station.guide.start_screen import unfinished_campaigns
    from station.guide.view import OperatorCommand

    with open_db(db) as database:
        found = unfinished_campaigns(database)
    if list_only:
        for each in found:
            typer.echo(f"{each.title}, {each.state}: {each.folder}")
        return
    if folder is not None and not any(Path(each.folder) == folder.resolve() for each in found):
        raise DataRefused(folder, None, "no unfinished campaign", "one that `station resume --list` names",
                          "it was cancelled or stored, or it is in another database (--db)")  # fmt: skip
    free = [Path(each.folder) for each in found if each.state == "free"]
    if folder is None and not free:
        raise DataRefused("database", None, "no unfinished campaign", "one that is free", "begin with `calibrate`")
    which = str(folder.resolve() if folder is not None else free[0])
    setup = load_setup().model_copy(update={"url": device})  # of a form, should this campaign be refused
    options = screen.engine(db, setup, first=OperatorCommand(verb="resume", folder=which))
    raise typer.Exit(guide(options, screen))
