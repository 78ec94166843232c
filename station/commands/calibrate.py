"""``station calibrate``: a live device to a calibration."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database


def calibrate(
    device: Annotated[str, typer.Option("--device", metavar="URL", help="The IMU, as in serial:///dev/ttyUSB0.")],
    out: Annotated[Path, typer.Option("--out", metavar="FOLDER", help="A new folder for the campaign.")],
    latitude: Annotated[float, typer.Option("--latitude", metavar="DEG", help="Geodetic latitude of the slab.")],
    headless: Annotated[
        bool, typer.Option("--headless", help="Plain lines, no screen: the only way so far.")
    ] = False,
    longitude: Annotated[float | None, typer.Option("--longitude", metavar="DEG")] = None,
    height: Annotated[float, typer.Option("--height", metavar="M", help="Above the ellipsoid.")] = 0.0,
    gravity: Annotated[
        float | None, typer.Option("--gravity", metavar="M/S2", help="Surveyed gravity; else the normal one.")
    ] = None,
    gravity_std: Annotated[
        float | None, typer.Option("--gravity-std", metavar="M/S2", help="Its 1 sigma.")
    ] = None,
    cube: Annotated[str | None, typer.Option("--cube", metavar="ID", help="The cube, see `fixtures`.")] = None,
    dwell_s: Annotated[
        float, typer.Option("--dwell-s", metavar="S", min=1.0, help="Accepted seconds per position.")
    ] = 100.0,
    turns: Annotated[int, typer.Option("--turns", metavar="N", min=1, help="Revolutions per hand turn.")] = 3,
    heading_std: Annotated[
        float, typer.Option("--heading-std", metavar="DEG", help="How well headings are set, 1 sigma.")
    ] = 0.1,
    closure_std: Annotated[
        float, typer.Option("--closure-std", metavar="DEG", help="How well turns close, 1 sigma.")
    ] = 0.02,
    model: Annotated[str | None, typer.Option("--model", help="For a device that does not say its own.")] = None,
    serial: Annotated[str | None, typer.Option("--serial", help="For a device that does not say its own.")] = None,
    hands: Annotated[
        str | None, typer.Option("--hands", metavar="HOST:PORT", help="Control address of a simulated device.")
    ] = None,
    move_s: Annotated[
        float, typer.Option("--move-s", metavar="S", help="Device time a simulated move takes.")
    ] = 45.0,
    db: Database = None,
) -> None:
    """Run a campaign of 12 positions and 6 hand turns on a live device, then solve, store and report.

    Plain lines say where to put the cube; the counts show when it rests there, and every accepted step is on the
    disk before it is said to be. In the folder: campaign.toml with a data file per step, the session's raw bytes,
    solution.json, calibration.json and report.html. Dwells are in seconds of device time, angles in deg.

    Exit code 4 if port or device fail, 130 on Ctrl-C; the accepted steps stay, for `station solve`.

    Example: station calibrate --headless --device serial:///dev/ttyUSB0?format=counts --latitude 48.1 --out c1
    """
    if not headless:
        raise typer.BadParameter("only --headless is there so far; the guided screen comes with a later version")
    from drivers.simulated.hands import SimulatedHands
    from fixtures_db.database import open_db
    from station.benches.campaign_run import CampaignRequest, is_expired, record_campaign
    from station.benches.console import ConsoleProgress
    from station.benches.hands import ConsoleHands, DeviceHands, Hands
    from station.campaign_folder.schema import ProcedureTable, SiteTable
    from station.commands._tables import checked

    request = CampaignRequest(
        url=device,
        folder=out,
        site=checked(
            SiteTable,
            latitude_deg=latitude,
            longitude_deg=longitude,
            height_m=height,
            gravity_m_s2=gravity,
            gravity_std_m_s2=gravity_std,
        ),
        procedure=checked(ProcedureTable, heading_std_deg=heading_std, closure_std_deg=closure_std),
        cube_id=cube,
        dwell_s=dwell_s,
        revolutions=turns,
        model=model,
        serial=serial,
    )
    progress = ConsoleProgress(total=18)
    mover: Hands = ConsoleHands(progress.say) if hands is None else DeviceHands(SimulatedHands(hands), move_s)
    with open_db(db) as database:
        try:
            unit = record_campaign(
                request,
                mover,
                database,
                progress,
                lambda unit: progress.say(f"connected: {unit.model} {unit.serial}"),
            )
        finally:
            if 0 < progress.accepted < 18:
                progress.say(f"{progress.accepted} of 18 steps are accepted, in {out}")
        from station.recorder.results import make_results
        from station.solution_text import solution_text

        results = make_results(out, database, is_expired=is_expired(database, cube))
    typer.echo(solution_text(results.document))
    typer.echo(f"verdict NOT MEASURED: no limits are stored for {unit.model}")
    for path in (results.report_file, results.solution_file, results.calibration_file):
        typer.echo(str(path))
