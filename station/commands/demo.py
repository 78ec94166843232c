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
    dwell_s: Annotated[float, option("--dwell-s", "S", "Device time per position.", min=1.0)] = 100.0,
    turns: Annotated[int, option("--turns", "N", "Revolutions per hand turn.", min=1)] = 3,
    no_turns: Annotated[
        bool, option("--no-turns", "", "Flip the cube among its 24 positions by trembling hands; no hand turn.")
    ] = False,
    db: Database = None,
) -> None:
    """Calibrate a simulated IMU over a real serial line (a pty) and write a report; under 2 minutes.

    A device process sends counts in device time, the reader process reads and journals them, simulated hands put
    the cube into 12 positions and turn it 6 times; the moves between are recorded too. The recorded bytes are
    decoded again and compared, the campaign is solved, and the simulator's truth stands beside every value, in
    count/(g s), count/deg, ug, deg/h, arcsec. Cube, slab, site and limits are the simulated unit's own, so that it
    ends in a verdict and a certificate that says DEMO. The demo has a database of its own in its folder unless
    --db or STATION_DB says otherwise.

    Exit code 2 if the folder is there and is not a demo's.

    Example: station demo --out demo --seed 1
    """
    import time

    from station.demo.comparison import compared, comparison_text
    from station.demo.run import DemoRequest, run_demo
    from station.guide.text_lines import PlainScreen
    from station.results.diagnosis.diagnosis_text import diagnosis_text

    began = time.monotonic()
    typer.echo(f"a simulated IMU on a pty, at {speed:g} times the speed of its own time")
    outcome = run_demo(
        DemoRequest(out, seed, speed, dwell_s, turns, db, not no_turns),
        PlainScreen(typer.echo, rings=False).show,
        lambda: typer.echo("recorded; decoding the raw bytes again, solving, diagnosing, writing the report"),
    )
    results = outcome.results
    typer.echo(f"raw bytes decoded again: {outcome.samples} samples, all counts equal")
    typer.echo("")
    typer.echo(comparison_text(compared(results.document, outcome.truth)))
    quality = results.solution.quality
    typer.echo(
        f"global test: chi2 {quality.chi2:.1f} of {quality.dof} degrees of freedom, p {quality.p_value:.2g}"
    )
    typer.echo("")
    typer.echo("what the model lacks:")
    typer.echo(diagnosis_text(results.diagnosis))
    typer.echo("")
    typer.echo(results.outcome.sentence)
    typer.echo(f"the calibration is stored, which at a bench is the operator's act: sha256 {outcome.sha256}")
    typer.echo(f"done in {time.monotonic() - began:.0f} s")
    typer.echo("")
    typer.echo(f"report       {results.report_file}")
    typer.echo(f"solution     {results.solution_file}")
    typer.echo(f"certificate  {outcome.certificate}")
    typer.echo(f"campaign     {outcome.campaign}")
