"""``station fixtures measure`` and ``tolerance``: a cube measured, and what its tolerances do."""

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from procedures.units import RAD_PER_ARCSEC, UG_PER_G
from station.commands import Database
from station.commands._options import argument, day_option, flag, option, write_result

if TYPE_CHECKING:
    from station.results.fixtures.measured_cube import CubeStudy


def measure(
    cube: Annotated[str, argument("CUBE", "The cube's name, the campaigns' fixture.id.")],
    campaigns: Annotated[list[Path], argument("CAMPAIGN", "Folders of campaign/1, any units.")],
    store: Annotated[bool, flag("--store", "Keep it as a measured certificate of the cube.")] = False,
    due: Annotated[datetime | None, day_option("Last day of validity, with --store.")] = None,
    on: Annotated[datetime | None, day_option("Day of it; else that of the campaigns, or today.")] = None,
    quadratic_sigma: Annotated[
        float, option("G", "Standard uncertainty of the units' K2 [g/g^2].", min=1e-9, max=1e-2)
    ] = 5e-5,
    json: Annotated[Path | None, option("OUT", "Write measured-cube/1 here instead of a summary.")] = None,
    db: Database = None,
) -> None:
    """Measure a cube with the IMUs that were calibrated in it: parallelism, skew, and how both changed.

    Results are in urad and arcsec with standard uncertainty. Twelve face positions cannot separate some values
    from a unit's K2: --quadratic-sigma states the uncertainty of K2. Campaigns with the IMU turned by 90 deg in
    the cube, and of several units, separate them.

    Exit code 3 if a campaign names another cube, the database has none of that name, or the same campaigns are
    stored as a measurement already, 5 if a campaign does not determine its accelerometers or the cube.

    Example: station fixtures measure CUBE-7 campaigns/2026-05-11 campaigns/2026-05-12 --store --due 2027-05-11
    """
    from fixtures_db.database import open_db
    from fixtures_db.fixture_measurements import add_measurement
    from fixtures_db.fixtures import fixture_row
    from fixtures_db.schema import CubeRow
    from station.commands.fixtures_add import day, due_after, noon, past
    from station.results.fixtures.measured_cube import read_campaigns, study

    if due is not None and not store:
        raise typer.BadParameter("--due without --store dates nothing; add --store")
    past(on)
    with open_db(db) as database, database.read() as session:
        fixture_row(session, CubeRow, cube)
    loaded = read_campaigns(cube, campaigns)
    with open_db(db) as database:
        with database.read() as session:
            found = study(session, cube, loaded, quadratic_sigma, None if on is None else noon(on))
        if store:
            due_after(found.measured_utc, due)
            _refuse_again(found)
            with database.write() as session:
                add_measurement(
                    session, cube, found.measured, campaigns=found.campaigns,
                    measured_utc=found.measured_utc, due_date=day(due),
                )  # fmt: skip
    from station.results.fixtures.fixture_listing import study_text
    from station.results.fixtures.measured_cube import document

    text = study_text(found) + (f"\nstored as measured certificate of cube {cube}" if store else "")
    write_result(document(found), text, json, f"cube {cube} as measured" + (", stored" if store else ""))


def _refuse_again(found: "CubeStudy") -> None:
    """Raise `DataRefused` if the same campaigns are stored: they say nothing new."""
    from station.errors import DataRefused

    if (at := found.stored_before) is not None:
        raise DataRefused(
            f"cube {found.cube}", None, f"the same campaigns stored as its measurement of {at:%Y-%m-%d}",
            "campaigns that are not", "measure with others, or without --store",
        )  # fmt: skip


def tolerance(
    cube: Annotated[str | None, argument("[CUBE]", "A cube of the database.")] = None,
    items: Annotated[Path | None, option("FILE.toml", "The drawing from a file instead.")] = None,
    want_ug: Annotated[float | None, option("", "The bias wanted, worst case [ug].", min=0)] = None,
    estimator: Annotated[Literal["twelve", "two", "joint"], option("", "Whose bias is wanted.")] = "joint",
    unit: Annotated[Path | None, option("SOLUTION.json", "E and D of this unit, else of Yao 2018's.")] = None,
    k2_ug: Annotated[float, option("", "K2 of every accelerometer [ug/g2].")] = 0.0,
    distribution: Annotated[
        Literal["uniform", "normal"],
        option("", "Distribution of an item; normal: tolerance = 2 standard deviations."),
    ] = "uniform",
    directions: Annotated[Literal["any", "p1"], option("", "In which directions faces tilt.")] = "any",
    cubes: Annotated[int, option("", "Number of random cubes.", min=1000, max=10_000_000)] = 200_000,
    certificate_arcsec: Annotated[
        float, option("", "Uncertainty u of a face certificate to compare with [arcsec].", min=1e-3)
    ] = 1.0,
    dwell_ug: Annotated[float, option("", "Standard deviation of a dwell's mean [ug].", min=1e-4)] = 0.14,
    svg: Annotated[Path | None, option("OUT.svg", "Draw the figure.")] = None,
    out: Annotated[Path | None, option("OUT.json", "Write tolerance/1.", names="--json")] = None,
    db: Database = None,
) -> None:
    """Compute how a cube's machining tolerances affect bias [ug], scale factor [ppm], misalignment [arcsec].

    For the 12-position, the two-direction and the joint estimator: the case of Yao, Hu and He 2018, the worst
    case, and the distribution over cubes made to the drawing. With --want-ug: the tolerance [mm] each item may
    have, which must be tightened and which may be relaxed, cheapest relaxation first. Then the gain from a face
    certificate, from turning the IMU in the cube, and from free positions.

    The items file holds side_mm, a table [tolerance_mm] of t1 ... t10, t4-1, t4-2, and optionally [cost] weights,
    [set_aside] sizes of what the paper sets aside (seat, slab, K2, gyroscopes, turns), [campaign] they act in.

    Exit code 3 if there is no such cube, an item is missing, or no cube gives the accuracy wanted.

    Example: station fixtures tolerance P1 --want-ug 100 --estimator twelve --svg tolerance.svg
    """
    if (cube is None) == (items is None):
        raise typer.BadParameter("of which cube? expected the name of one, or --items FILE.toml, not both")
    if want_ug is not None and not want_ug > 0:
        raise typer.BadParameter(f"--want-ug {want_ug}: expected more than zero")
    from procedures.tolerance.tolerances_for_accuracy import AccuracyUnreachable
    from station.errors import DataRefused
    from station.files.atomic_file import replace_file, write_json
    from station.results.fixtures.tolerance_study import (
        ToleranceQuestion,
        document,
        drawing_of_cube,
        drawing_of_file,
        paper_unit,
        study,
        unit_of_solution,
    )
    from station.results.fixtures.tolerance_text import tolerance_text

    drawing = drawing_of_file(items) if items is not None else drawing_of_cube(db, str(cube))
    judged = paper_unit(k2_ug * 1e-6) if unit is None else unit_of_solution(unit, k2_ug * 1e-6)
    wanted = None if want_ug is None else want_ug * 1e-6
    asked = (wanted, certificate_arcsec * RAD_PER_ARCSEC, dwell_ug * 1e-6)
    try:
        found = study(drawing, judged, ToleranceQuestion(cubes, distribution, directions, estimator, *asked))
    except AccuracyUnreachable as error:
        asked_for, least = (
            f"a bias within {error.wanted * UG_PER_G:.4g} ug wanted",
            f"{error.left * UG_PER_G:.4g} ug or more",
        )
        remedy = "the limit of a perfect cube; use another estimator, or correct for K2"
        raise DataRefused(f"cube {drawing.cube}", None, asked_for, least, remedy) from None
    if svg is not None:
        from station.results.fixtures.tolerance_text import tolerance_svg

        replace_file(svg, tolerance_svg(found).encode())
    if out is not None:
        write_json(out, document(found))
    else:
        typer.echo(tolerance_text(document(found)))
