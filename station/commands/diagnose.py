"""``station diagnose``: what the residual of recorded campaigns says the model lacks."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from station.commands import Database
from station.commands._options import argument, hand_out, option

if TYPE_CHECKING:
    from procedures.diagnosis.result import Diagnosis
    from station.files.campaign_folder.loaded_campaign import LoadedCampaign


def diagnose(
    campaigns: Annotated[list[Path], argument("CAMPAIGN", "Folders of campaign/1.")],
    validate: Annotated[
        list[Path] | None, option("--validate", "CAMPAIGN", "Test the findings on this one of the same unit.")
    ] = None,
    partial: Annotated[
        bool, option("--partial", "", "Report what can be known even if no triad can be solved.")
    ] = False,
    plan: Annotated[Path | None, option("--plan", "FILE", "Write the next measurement as plan/1.")] = None,
    json: Annotated[Path | None, option("--json", "OUT", "Write diagnosis/1 here instead of a summary.")] = None,
    html: Annotated[Path | None, option("--html", "FILE", "Write a page with plots here.")] = None,
    db: Database = None,
) -> None:
    """Find what the residual says the model lacks, name it or say that it cannot be named, and add it.

    The verdict is one of consistent, established, likely, ambiguous, partly, unexplained. Each finding has
    its coefficients with 1 sigma (ug, arcsec, ppm, deg/h), how sure its name is, how much it explains, what
    else it could be and what would tell. The error before and after is that of positions, turns and rests left
    out in turn; with --validate also that of another campaign with the coefficients as they were found here.

    Exit code 0 whatever the verdict, 3 if a folder breaks a rule of campaign/1, 5 if neither triad can be solved.

    Example: station diagnose campaigns/2026-05-11 --validate campaigns/2026-05-12 --plan next.toml
    """
    from procedures.errors import NotObservable
    from station.files.campaign_folder.campaign_reading import read_campaign
    from station.files.campaign_folder.loaded_campaign import check_one_unit
    from station.results.diagnosis.single_channels import channel_lines, channels_of
    from station.results.diagnosis.unsolvable_campaign import partial_document

    loaded, others = ([read_campaign(folder) for folder in folders] for folders in (campaigns, validate or []))
    check_one_unit([*loaded, *others])
    from procedures.diagnosis.diagnose import diagnose as find  # scipy and kernels: not before the data are right
    from station.results.diagnosis.magnetic_field import with_magnetic_field

    loaded, others = ([with_magnetic_field(one) for one in several] for several in (loaded, others))

    try:
        found = find([one.campaign for one in loaded])
    except NotObservable as error:
        if not partial:
            for line in channel_lines(channels_of(loaded, ())):
                typer.echo(line)
            raise
        if (part := partial_document(loaded, error)) is None:
            raise
        _say(part, loaded, None, json, html, plan)
    else:
        _say(_document(found, loaded, others), loaded, found, json, html, plan)


def _document(
    found: "Diagnosis", loaded: Sequence["LoadedCampaign"], others: Sequence["LoadedCampaign"]
) -> dict[str, Any]:
    from station.results.diagnosis.diagnosis_json import diagnosis_document

    validated = {}
    if others:
        from procedures.diagnosis.validation_campaigns import validate

        validated = {str(one.folder): validate(found, [one.campaign]) for one in others}
    return diagnosis_document(found, loaded, validated)


def _say(
    document: dict[str, Any], loaded: Sequence["LoadedCampaign"], found: "Diagnosis | None", json: Path | None,
    html: Path | None, plan: Path | None,
) -> None:  # fmt: skip
    from station.results.diagnosis.diagnosis_text import diagnosis_text

    unit = f"{loaded[0].campaign.model} {loaded[0].campaign.serial}"
    hand_out(document, diagnosis_text(document), json, f"diagnosis of {unit}, diagnosis/1")
    if html is not None:
        from station.results.diagnosis.diagnosis_html import write_page

        write_page(html, document, found)
        typer.echo(f"{html}: diagnosis of {unit}")
    if plan is not None:
        from procedures.frames import FACES
        from station.results.diagnosis.next_measurements import next_measurements, write_plans

        is_certified = all(len(one.campaign.fixture.faces) == len(FACES) for one in loaded)
        axes = loaded[0].tables.fixture.imu_axes
        for file in write_plans(plan, next_measurements(document["findings"], axes, is_certified)):
            typer.echo(f"{file}: what to measure next, for `station calibrate --plan {file}`")
