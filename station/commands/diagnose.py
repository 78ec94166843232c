"""``station diagnose``: what the residual of recorded campaigns says the model lacks."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any

import typer

from station.commands import Database
from station.commands._log_options import LogOptions, means_of_logs, read_logs
from station.commands._options import Effects, argument, flag, option, refuse_other_than_toml, write_result

if TYPE_CHECKING:
    from procedures.discovery.discover import Discovery
    from procedures.inference.result import Diagnosis
    from station.files.campaign_folder.loaded_campaign import LoadedCampaign
    from station.files.logs.means_table import MeansTable


def diagnose(
    campaigns: Annotated[list[Path], argument("RECORDING", "Folders of campaign/1, or logs of one unit.")],
    validate: Annotated[
        list[Path] | None, option("RECORDING", "Test the findings on this other campaign of the unit.")
    ] = None,
    *,
    log: LogOptions,
    effects: Effects = None,
    discover: Annotated[
        bool, flag("--discover", "Search ten thousand terms for an error term that the catalogue lacks.")
    ] = False,
    plan: Annotated[Path | None, option("FILE", "Write the next measurement as plan/1.")] = None,
    json: Annotated[Path | None, option("OUT", "Write diagnosis/2 here instead of a summary.")] = None,
    html: Annotated[Path | None, option("FILE", "Write a page with plots here.")] = None,
    partial: Annotated[
        bool, flag("--partial", "Report the findings even if no triad can be solved; always for logs.")
    ] = False,
    db: Database = None,
) -> None:
    """Find the error terms that the model lacks, in a campaign or any log, and add them to the model.

    The verdict is one of consistent, established, likely, ambiguous, partly, unexplained. Each finding has its
    coefficients with standard uncertainty u (ug, arcsec, ppm, deg/h), the probability of its name, the
    alternatives, and the measurement that separates them. The error before and after is that of held-out
    positions, rotations and rests; with --validate also that of another campaign, with the coefficients found
    here.

    A log is a table from another source: text with any delimiter, .mat, .npz or .parquet. With --as means it is a
    table of mean outputs, one row per pose, which gives bias, scale factor, misalignment and the poses that
    contradict the others. Missing column names and units are inferred from the file; every inference is printed.

    Exit code 0 for every verdict, also if a log or a soak determines no calibration; 3 if a folder or a log breaks
    a rule, 5 if a folder's positions solve neither triad (without --partial), the poses of a table determine no
    calibration, or the data show nothing.

    Example: station diagnose log.csv --time t --gyro wx,wy,wz --unit-gyro deg/s --temperature temp
    """
    from station.files.campaign_folder.campaign_reading import read_campaign
    from station.files.campaign_folder.loaded_campaign import check_one_unit, with_effects

    refuse_other_than_toml(plan, "--plan")
    if log.are_logs(campaigns) and (means := means_of_logs(campaigns, log)) is not None:
        used = {"--validate": validate, "--effects": effects, "--discover": discover, "--plan": plan}
        if refused := [name for name, value in used.items() if value]:
            raise typer.BadParameter(f"{refused[0]} is not for a table of means")
        _report_means(means, log, json, html)
        return
    if log.are_logs(campaigns):
        loaded, partial = [read_logs(campaigns, log, log.campaign)], True
    else:
        if not any(log.are_logs([path]) for path in validate or []):
            log.refuse_with_folders()
        loaded = [read_campaign(folder) for folder in campaigns]
    others = {
        str(path): read_logs([path], log) if log.are_logs([path]) else read_campaign(path)
        for path in validate or []
    }
    check_one_unit([*loaded, *others.values()])
    loaded = with_effects(loaded, effects or [])
    _diagnose(loaded, others, json, html, plan, is_partial=partial, is_searched=discover)


def _report_means(means: "MeansTable", log: LogOptions, json: Path | None, html: Path | None) -> None:
    from station.results.diagnosis.diagnosis_html import write_shown
    from station.results.diagnosis.diagnosis_text import text_of
    from station.results.diagnosis.means_document import means_document
    from station.results.means_wording import document_of_means

    document = means_document(means, log.latitude, log.serial)
    shown, what = document_of_means(document), f"diagnosis of means of {document['poses']} poses"
    write_result(document, text_of(shown), json, f"{what}, means/2")
    if html is not None:
        write_shown(html, shown, document)
        typer.echo(f"{html}: {what}")


def _diagnose(
    loaded: "Sequence[LoadedCampaign]", others: "Mapping[str, LoadedCampaign]", json: Path | None,
    html: Path | None, plan: Path | None, *, is_partial: bool, is_searched: bool,
) -> None:  # fmt: skip
    from procedures.diagnosis.diagnose import diagnose as find  # scipy and kernels: not before the data are right
    from procedures.errors import NotObservable
    from station.files.campaign_folder.loaded_campaign import effects_of
    from station.results.diagnosis.diagnosis_document import channel_table
    from station.results.diagnosis.diagnosis_text import section_lines
    from station.results.diagnosis.magnetic_field import with_magnetic_field
    from station.results.diagnosis.uncalibrated import channels_of
    from station.results.diagnosis.unsolvable_campaign import nothing_at_all, partial_document

    loaded = [with_magnetic_field(one) for one in loaded]
    others = {name: with_magnetic_field(one) for name, one in others.items()}
    try:
        found = find([one.campaign for one in loaded], declared=[one.term for one in effects_of(loaded)])
    except NotObservable as error:
        if not is_partial:
            for line in section_lines(channel_table(channels_of(loaded, ()))):
                typer.echo(line)
            raise
        if (part := partial_document(loaded, error)) is None:
            raise nothing_at_all(loaded, error) from error
        _say(part, loaded, None, json, html, plan)
    else:
        loaded = [replace(one, campaign=each) for one, each in zip(loaded, found.looked_at, strict=True)]
        document, more = _document(found, loaded, others), None
        if is_searched:
            from procedures.discovery.discover import discover

            more = discover(found, lambda line: typer.echo(line, err=True))
        _say(document, loaded, found, json, html, plan, more)


def _document(
    found: "Diagnosis", loaded: Sequence["LoadedCampaign"], others: "Mapping[str, LoadedCampaign]"
) -> dict[str, Any]:
    from station.results.diagnosis.diagnosis_json import diagnosis_json
    from station.results.diagnosis.model_refinement import with_undetectable_tilts

    validated = {}
    if others:
        from procedures.diagnosis.validation_campaigns import validate

        validated = {name: validate(found, [one.campaign]) for name, one in others.items()}
    return diagnosis_json(with_undetectable_tilts(found), loaded, validated)


def _say(
    document: dict[str, Any], loaded: Sequence["LoadedCampaign"], found: "Diagnosis | None", json: Path | None,
    html: Path | None, plan: Path | None, more: "Discovery | None" = None,
) -> None:  # fmt: skip
    from station.results.diagnosis.diagnosis_json import noise_and_widened
    from station.results.diagnosis.diagnosis_text import diagnosis_text
    from station.text import WIDTH, unit_in_words

    document |= noise_and_widened(loaded, found)
    if guesses := [guess for one in loaded for guess in one.guesses]:
        document["guessed"] = guesses
    if more is not None:
        from station.results.diagnosis.proposed_terms import with_proposed

        document = with_proposed(document, more)
    imu = loaded[0].tables.imu
    unit = unit_in_words(imu.model, imu.serial, (name for one in loaded for name in one.files))
    write_result(document, diagnosis_text(document), json, f"diagnosis of {unit}, diagnosis/2")
    if html is not None:
        from station.results.diagnosis.diagnosis_html import write_page

        write_page(html, document, found, more)
        typer.echo(f"{html}: diagnosis of {unit}")
    if plan is not None:
        from station.results.diagnosis.log_measurements import wanted
        from station.results.diagnosis.next_measurements import write_plans
        from station.results.diagnosis.proposed_terms import planned

        next_ones = wanted(document, loaded, planned(document))
        guided = any(one.steps for one in next_ones)
        for file, texts in write_plans(plan, next_ones).items():
            way = f"for `station calibrate --plan {file}`" if guided else "in words: no step of it can be guided"
            typer.echo(f"{file}: what to measure next, {way}")
            for each in texts:
                typer.echo(fill(each, WIDTH, initial_indent="  ", subsequent_indent="  "))
