"""A diagnosis as HTML: the section that a report ends with, and a page of its own."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from station.files.atomic_file import replace_file
from station.results.diagnosis.diagnosis_document import CAUSE_COLUMNS, STILL_IN, DiagnosisDocument, document_of
from station.results.html_templates import html_template
from station.results.report.noise_page import noise_section

if TYPE_CHECKING:
    from procedures.discovery.discover import Discovery
    from procedures.inference.result import Diagnosis


def write_page(
    path: Path, document: Mapping[str, Any], diagnosis: "Diagnosis | None", more: "Discovery | None" = None
) -> None:
    """Write a diagnosis, and what a search found ``more``, as one self-contained HTML file.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    _write(path, section_html(document, diagnosis, more), document.get("solution", document), document)


def write_shown(path: Path, shown: DiagnosisDocument, found: Mapping[str, Any]) -> None:
    """Write what is ``shown`` of a result ``found`` by another way as the same page.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    _write(path, _section(shown, {}), found, found)


def _write(path: Path, section: str, solution: Mapping[str, Any], found: Mapping[str, Any]) -> None:
    page = html_template("page.html")
    origin, guessed = solution["provenance"], found.get("guessed")
    replace_file(path, page.render(origin=origin, section=Markup(section), guessed=guessed).encode())


def section_html(
    document: Mapping[str, Any], diagnosis: "Diagnosis | None", more: "Discovery | None" = None
) -> str:
    """Return the section "What the model lacks" of a `diagnosis/2`, with plots where the diagnosis is at hand."""
    shown = document_of(document)
    return _section(shown, {} if diagnosis is None else _plots(document, diagnosis, more))


def _section(shown: DiagnosisDocument, plots: Mapping[tuple[str, str], Mapping[str, Any]]) -> str:
    noise = Markup(noise_section(shown.noise))
    return html_template("section.html").render(
        document=shown, columns=CAUSE_COLUMNS, plots=plots, noise=noise, still_in=STILL_IN
    )


def _plots(
    document: Mapping[str, Any], diagnosis: "Diagnosis", more: "Discovery | None"
) -> dict[tuple[str, str], dict[str, Any]]:
    """Return a plot with its caption by error term and place; what acts on samples or is proposed has no place."""
    from station.results.diagnosis.finding_figure import (
        caption,
        folded_panels,
        in_outputs,
        proposed_panels,
        residual_panels,
        residual_svg,
    )

    panels = residual_panels(diagnosis)
    panels += proposed_panels(more) if more is not None else []
    panels += folded_panels(diagnosis)
    if not diagnosis.is_calibrated:
        scales = diagnosis.before.campaigns[0].nominal_scale
        units = {each["quantity"].partition(" ")[0]: each["unit"] for each in document["error"]}
        panels = [each if each.triad in scales else in_outputs(each, units[each.triad]) for each in panels]
    first = {(panel.effect, panel.place): panel for panel in reversed(panels)}
    return {
        key: {"plot": Markup(residual_svg(number, panel)), "caption": caption(panel)}
        for number, (key, panel) in enumerate(first.items(), 1)
    }
