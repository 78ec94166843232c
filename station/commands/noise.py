"""``station noise``: Allan deviation, its terms, spectrum and lines of recordings at rest."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._log_options import COLUMNS, LogOptions, read_logs
from station.commands._options import argument, option, write_result

if TYPE_CHECKING:
    from station.files.campaign_folder.loaded_campaign import LoadedCampaign
    from station.results.report.noise_document import NoiseDocument


def noise(
    recordings: Annotated[list[Path], argument("RECORDING", "Folders of campaign/1, or logs of one unit.")],
    log: Annotated[LogOptions, (*COLUMNS, "as_", "serial")],
    json: Annotated[Path | None, option("OUT", "Write noise/1 here instead of a summary.")] = None,
    html: Annotated[Path | None, option("FILE", "Write a page with the plot here.")] = None,
    png: Annotated[Path | None, option("FILE", "Write the plot here.")] = None,
    db: Database = None,
) -> None:
    """Compute the noise of every channel in its longest recording at rest.

    Overlapping Allan deviation; quantisation Q, random walk N, bias instability B, rate random walk K and ramp R
    (IEEE 952, 647), fitted together with 95 % intervals, or as a bound if the curve does not show them; spectrum,
    and its lines. Gyroscopes are in deg/h, accelerometers in ug, or outputs if no unit is known. A campaign's
    counts are scaled by its own solution.

    Exit code 0; 3 if a folder or a log breaks a rule, 5 if nothing is long enough.

    Example: station noise fog.csv --time t --gyro -,-,rate --unit-gyro deg/s --png allan.png
    """
    document = _document(_loaded(recordings, log))
    from station.results.report.noise_document import noise_text
    from station.results.result_formats import document_of

    write_result(document_of(document), noise_text(document), json, document.format)
    if html is not None:
        from station.results.report.noise_page import write_noise_page

        write_noise_page(html, document)
        typer.echo(f"{html}: noise")
    if png is not None:
        from station.results.report.noise_page import write_noise_png

        write_noise_png(png, document.channels)
        typer.echo(f"{png}: Allan deviation and spectrum")


def _loaded(recordings: Sequence[Path], log: LogOptions) -> "list[LoadedCampaign]":
    from station.files.campaign_folder.campaign_reading import read_campaign
    from station.files.campaign_folder.loaded_campaign import check_one_unit

    if log.are_logs(recordings):
        return [read_logs(recordings, replace(log, temperature=""), uses_latitude=False)]
    log.refuse_with_folders()
    loaded = [read_campaign(folder) for folder in recordings]
    check_one_unit(loaded)
    return loaded


def _document(loaded: "Sequence[LoadedCampaign]") -> "NoiseDocument":
    from procedures.calibration.joint_calibration import solve
    from procedures.errors import NotObservable, ProcedureError
    from station.results.report.noise_document import noise_document

    try:
        solution = solve([one.campaign for one in loaded])
    except ProcedureError:
        solution = None  # then in the units specified, or in outputs
    document = noise_document(loaded, solution)
    if not document.channels:
        raise NotObservable(
            "the noise of any channel", ("64 samples at rest without a gap, of a channel that changes",)
        )
    return document
