"""``station demo``: the main job on simulated devices, end to end."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import option


def demo(
    out: Annotated[Path, option("--out", "FOLDER", "Everything goes here.")] = Path("demo"),
    seed: Annotated[int, option("--seed", "", "Which random unit.")] = 1,
    speed: Annotated[float, option("--speed", "N", "Device seconds per second.", min=0.1)] = 60.0,
    dwell_s: Annotated[float, option("--dwell-s", "S", "Device time per position.", min=1.0)] = 60.0,
    turns: Annotated[int, option("--turns", "N", "Revolutions per manual rotation.", min=1)] = 2,
    no_turns: Annotated[
        bool, option("--no-turns", "", "Flip the cube among its 24 positions by trembling hands; no rotation.")
    ] = False,
    db: Database = None,
) -> None:
    """Calibrate a simulated IMU over a real serial line (a pty), find its error, and write report and certificate.

    Gyroscope z also measures the magnetic field: nobody declares that. A device process sends counts, the reader
    process records them, simulated hands put the cube into 12 positions and turn it 6 times. The recorded bytes
    are decoded again and compared, the campaign is solved and diagnosed, and all is compared with the simulator's
    truth. Cube, surface plate, site and limits are the simulated unit's own. The demo has a database of its own in
    its folder unless --db or STATION_DB names another.

    Exit code 2 if the folder is there and is not a demo's.

    Example: station demo --out demo --seed 1
    """
    import time

    from rich.console import Console

    from station.demo.comparison import compared, comparison_text
    from station.demo.findings_text import findings_lines
    from station.demo.progress import DemoProgress
    from station.demo.run import DemoRequest, run_demo

    began = time.monotonic()
    typer.echo(f"a simulated IMU on a serial line, {speed:g} times as fast as real time")
    with DemoProgress(Console()) as progress:
        outcome = run_demo(
            DemoRequest(out, seed, speed, dwell_s, turns, db, not no_turns),
            progress.show,
            lambda: progress.busy("recorded; now solving, diagnosing, writing the report"),
        )
    results = outcome.results
    typer.echo(f"raw bytes decoded again: {outcome.samples} samples, all counts equal")
    typer.echo("")
    typer.echo(comparison_text(compared(results.document, outcome.truth)))
    typer.echo("")
    for line in findings_lines(results.diagnosis):
        typer.echo(line)
    typer.echo("")
    typer.echo(results.outcome.sentence)
    typer.echo(f"done in {time.monotonic() - began:.0f} s: {results.report_file}, {outcome.certificate}")
    typer.echo("try next:")
    typer.echo(f"  station diagnose {outcome.campaign}")
    typer.echo(f"  station solve {outcome.campaign} --json solution.json")
    typer.echo("  station calibrate           # the guided screen; docs/how-to/guided-calibration.md")
