"""``station demo``: the main job on simulated devices, end to end."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import flag, option

WIDTH = 80  # columns


def demo(
    out: Annotated[Path, option("FOLDER", "Folder for all results.")] = Path("demo"),
    seed: Annotated[int, option("", "Number of the random unit.")] = 1,
    speed: Annotated[float, option("N", "Device seconds per second.", min=0.1)] = 60.0,
    dwell_s: Annotated[float, option("S", "Device time per position.", min=1.0)] = 60.0,
    turns: Annotated[int, option("N", "Revolutions per manual rotation.", min=1)] = 2,
    no_turns: Annotated[
        bool, flag("--no-turns", "Flip the cube among its 24 positions with tremor; no rotation.")
    ] = False,
    db: Database = None,
) -> None:
    """Calibrate a simulated IMU over a real serial line (a pty); write report and certificate.

    Gyroscope z also measures the magnetic field, which is not part of the declared model. A device process sends
    counts, the reader process records them, simulated hands put the cube into 12 positions and rotate it 6 times.
    The recorded bytes are decoded again and compared, the campaign is solved and diagnosed, and the result is
    compared with the simulator's truth. Cube, surface plate, site and limits belong to the simulated unit. The
    demo has a database of its own in its folder unless --db or STATION_DB names another.

    Exit code 2 if the folder exists and was not made by a demo.

    Example: station demo --out demo --seed 1
    """
    import time
    from textwrap import wrap

    from rich.console import Console

    from station.demo.comparison import compared, comparison_text, findings_lines
    from station.demo.run import DemoProgress, DemoRequest, run_demo

    began = time.monotonic()
    typer.echo(f"simulated IMU on a serial line, {speed:g} times as fast as real time")
    with DemoProgress(Console()) as progress:
        outcome = run_demo(
            DemoRequest(out, seed, speed, dwell_s, turns, db, not no_turns),
            progress.show,
            lambda: progress.busy("solving, diagnosing, writing the report"),
        )
    results = outcome.results
    typer.echo(f"recorded bytes decoded again: all {outcome.samples} samples equal")
    typer.echo("")
    typer.echo(comparison_text(compared(results.document, outcome.truth)))
    typer.echo("")
    for line in findings_lines(results.diagnosis):
        typer.echo(line)
    typer.echo("")
    typer.echo("\n".join(wrap(results.outcome.sentence, WIDTH, break_long_words=False)))
    typer.echo(f"report:      {results.report_file}")
    typer.echo(f"certificate: {outcome.certificate}")
    typer.echo(f"done in {time.monotonic() - began:.0f} s; try next:")
    typer.echo(f"  station diagnose {outcome.campaign}")
    typer.echo(f"  station solve {outcome.campaign}")
    typer.echo("  station calibrate")
