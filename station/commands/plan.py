"""``station plan``: the campaign that meets limits in the least time, or determines most in a time given."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._options import Noise, flag, option, refuse_other_than_toml, refused_as, write_result

if TYPE_CHECKING:
    from procedures.planning.design_sigmas import DesignSigmas, WantedSigmas


def plan(
    limits: Annotated[
        str | None, option("MODEL|FILE", "Limits to be met: those stored of a model, or a limits.toml.")
    ] = None,
    sigma: Annotated[
        list[str] | None, option("NAME=SIGMA", "A target for a standard uncertainty; repeatable.")
    ] = None,
    serial: Annotated[str | None, option("SERIAL", "The unit; its noise comes from its history.")] = None,
    noise: Noise = None,
    cube: Annotated[str | None, option("ID", "The cube, with its face certificates.")] = None,
    latitude: Annotated[
        float | None,
        option("DEG", "Of the surface plate; else of a named campaign, or of the last set-up.", min=-90, max=90),
    ] = None,
    minutes: Annotated[
        float | None, option("M", "The best result within so many minutes.", min=1, max=1e4)
    ] = None,
    no_turns: Annotated[bool, flag("--no-turns", "Plan no manual rotations.")] = False,
    json: Annotated[Path | None, option("OUT", "Write planned/1 here instead of a summary.")] = None,
    out: Annotated[Path | None, option("PLAN", "Write plan/1 here, for `station calibrate --plan`.")] = None,
    so_far: Annotated[
        Path | None, option("CAMPAIGN", "Name the next placement of an unfinished campaign.", names="--continue")
    ] = None,
    db: Database = None,
) -> None:
    """Plan the campaign that meets limits in the least time for this unit's noise.

    The search covers the order of placements among the 24 attitudes of a cube, the time in each, and whether
    manual rotations help; transfers between placements count too. Every standard uncertainty is listed with that
    of the usual plan and its target: an eighth of a limit's half interval, or what a known value leaves to its
    guard band. The uncertainty of all other parameters may grow to at most ten times the usual value. NAME=SIGMA
    is for example gyroscope.bias=0.02deg/h, accelerometer.bias=0.1ug, gyroscope.scale_factor=3ppm,
    gyroscope.misalignment=2arcsec.

    --continue names the placement that reduces a campaign's uncertainty fastest, the uncertainties reached and the
    time that remains. It uses the steps done and their durations, never the values found. It needs --limits or
    --sigma.

    The noise is that of the unit's newest campaigns in the database, else of its model's, else of --noise.

    Exit code 1 if a target cannot be reached; 3 if limits or noise are not known.

    Example: station plan --limits FOG-3 --serial 1042 --cube CUBE-7 --out plan.toml

    Example: station plan --sigma gyroscope.bias=0.02deg/h --noise campaigns/S123 --minutes 15
    """
    from fixtures_db.database import open_db
    from procedures.planning.design_sigmas import DesignSigmas
    from procedures.planning.step_information import StepInformation
    from station.guide.campaign.campaign_tables import planned_bench
    from station.results.plan_inputs import (
        hand_times,
        known_noise,
        last_values,
        limits_named,
        wanted_by,
        wanted_by_name,
    )

    with refused_as("--sigma"):
        asked = wanted_by_name(sigma or [])
    if so_far is not None:
        _refuse_with_continue(has_wanted=bool(limits or sigma), others=(minutes, json, out, no_turns or None))
    refuse_other_than_toml(out, "--out")
    with open_db(db) as database:
        model, rows = limits_named(database, limits)
        known = known_noise(database, model, serial, noise or [])
        by_limits, remarks = wanted_by(rows, last_values(database, model, serial))
        hands, timed = hand_times(database)
        bench = planned_bench(database, cube, latitude, [*(noise or []), *([so_far] if so_far else [])])
    for remark in remarks:
        typer.echo(remark, err=True)
    sigmas = DesignSigmas(StepInformation(bench, known.noise, hands))
    if so_far is not None:
        _continue(sigmas, asked.and_also(by_limits), so_far)
        return
    stated = {"noise": known.source, "hands": timed}
    _plan(sigmas, asked.and_also(by_limits), minutes, stated, json, out, turns=not no_turns)


def _refuse_with_continue(*, has_wanted: bool, others: tuple[object, ...]) -> None:
    with refused_as("--continue"):
        if not has_wanted:
            raise ValueError("found no target, expected --limits or --sigma with it")
        if any(other is not None for other in others):
            raise ValueError("it names the next placement: omit --minutes, --no-turns, --json and --out")


def _continue(sigmas: "DesignSigmas", asked: "WantedSigmas", so_far: Path) -> None:
    from procedures.planning.campaign_design import usual_design
    from procedures.planning.design_sigmas import with_all_solved
    from procedures.planning.least_time import next_placement
    from station.results.plan_document import continued_text, placements_of

    whole = with_all_solved(asked, sigmas.of(usual_design()))
    found = next_placement(sigmas, whole, placements_of(so_far))
    typer.echo(continued_text(found, asked, whole))
    if not found.is_reachable:
        raise typer.Exit(1)


def _plan(
    sigmas: "DesignSigmas", asked: "WantedSigmas", minutes: float | None, stated: dict[str, str],
    json: Path | None, out: Path | None, *, turns: bool,
) -> None:  # fmt: skip
    import numpy as np

    from procedures.planning.campaign_design import usual_design
    from procedures.planning.design_sigmas import as_good_as, with_all_solved
    from procedures.planning.least_time import least_time, most_in_time
    from station.files.campaign_folder.plan_file import write_plan
    from station.results.plan_document import plan_of, plan_text
    from station.results.result_formats import document_of

    usual = sigmas.of(usual_design())
    is_asked = bool(np.isfinite(asked.sigma).any())
    whole = with_all_solved(asked, usual) if is_asked else as_good_as(usual)
    if minutes is None:
        found = least_time(sigmas, whole, turns=turns)
    else:
        with refused_as("--minutes"):
            found = most_in_time(sigmas, whole, minutes, turns=turns)
    plan = plan_of(found, asked, sigmas, stated)
    write_result(document_of(plan), plan_text(plan), json, plan.format)
    if out is not None:
        write_plan(out, found.design.steps())
        typer.echo(f"{out}: for `station calibrate --plan {out}`")
    if not plan.is_met:
        raise typer.Exit(1)
