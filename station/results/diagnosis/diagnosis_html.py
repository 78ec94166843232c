"""A diagnosis as HTML: the section that a report ends with, and a page of its own."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from station.files.atomic_file import replace_file
from station.results.diagnosis.diagnosis_text import (
    RATE_TABLE_TITLE,
    cause_rows,
    coefficient_rows,
    error_rows,
    moved_rows,
    proposed_in_words,
    readings_in_words,
    searched_in_words,
    table_rows,
    warnings_of,
)  # fmt: skip
from station.results.diagnosis.diagnosis_wording import (
    LEFT_TITLE,
    OTHERS_TITLE,
    PROPOSED,
    alternatives_in_words,
    confidence_in_words,
    equation_of,
    left_lines,
    not_separable_in_words,
    notes,
    other_terms,
    shown_unit,
    verdict_sentence,
    verdict_title,
    where_text,
)
from station.results.html_templates import html_template
from station.results.report.noise_page import noise_section
from station.results.solution_text import effect_lines

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
    page = html_template("page.html")
    origin, section = (
        document.get("solution", document)["provenance"],
        Markup(section_html(document, diagnosis, more)),
    )
    replace_file(path, page.render(origin=origin, section=section, guessed=document.get("guessed")).encode())


def section_html(
    document: Mapping[str, Any], diagnosis: "Diagnosis | None", more: "Discovery | None" = None
) -> str:
    """Return the section "What the model lacks" of a `diagnosis/2`, with plots where the diagnosis is at hand."""
    plots = {} if diagnosis is None else _plots(diagnosis, more)
    findings = [
        _finding(finding) | plots.get(finding["effect"], {"plot": "", "caption": ""})
        for finding in document["findings"]
    ]
    return html_template("section.html").render(
        noise=Markup(noise_section(document.get("noise", ()))), wider=_wider(document),
        document=document, title=verdict_title(document), sentence=verdict_sentence(document), findings=findings,
        errors=error_rows(document["error"]), moved=moved_rows(document["parameters"]),
        searched=searched_in_words(document), on_table=RATE_TABLE_TITLE,
        others=other_terms(document), others_title=OTHERS_TITLE, causes=cause_rows(document),
        not_separable=not_separable_in_words(document),
        left=left_lines(document), left_title=LEFT_TITLE, of_table=table_rows(document.get("solution", {})),
        warnings=warnings_of(document.get("solution", document)),
        declared=[_declared(one) for one in document.get("solution", {}).get("effects", ())],
    )  # fmt: skip


def _declared(effect: Mapping[str, Any]) -> tuple[str, list[list[str]]]:
    """Return a declared effect's title and its rows: coefficient, value."""
    title, *rows = effect_lines(effect)
    return title, [row.split(maxsplit=1) for row in rows]


def _wider(document: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Return the parameters whose expanded uncertainty what is left widens most: name, without, with it, unit."""
    rows = []
    for one in document.get("widened", ()):
        factor, unit = shown_unit(one["unit"])
        sizes = [f"{one[key] * factor:.3g}" for key in ("expanded_without", "expanded")]
        rows.append((one["name"].replace(".", " ").replace("_", " "), *sizes, unit))
    return rows


def _plots(diagnosis: "Diagnosis", more: "Discovery | None") -> dict[str, dict[str, Any]]:
    from station.results.diagnosis.finding_figure import caption, folded_panels, residual_panels, residual_svg

    found, panels = dict[str, dict[str, Any]](), residual_panels(diagnosis)
    if more is not None and more.proposals:
        from station.results.diagnosis.finding_figure import proposed_panels

        panels += proposed_panels(more)
    for number, panel in enumerate(panels, 1):
        if panel.effect not in found:
            found[panel.effect] = {"plot": Markup(residual_svg(number, panel)), "caption": caption(panel)}
    for number, folded in enumerate(folded_panels(diagnosis), 1):
        if folded.effect not in found:
            found[folded.effect] = {
                "plot": Markup(residual_svg(100 + number, folded)), "caption": caption(folded)
            }  # fmt: skip
    return found


def _finding(finding: Mapping[str, Any]) -> dict[str, Any]:
    return {
        **finding,
        "where": where_text(finding["where"]),
        "sure": confidence_in_words(finding),
        "aliases": alternatives_in_words(finding),
        "equation": equation_of(finding),
        "rows": coefficient_rows(finding),
        "notes": [
            *(note for note in notes(finding) if not note.startswith("shape: ")),
            *(proposed_in_words(finding)[1:] if finding["confidence"] == PROPOSED else ()),
        ],
        "readings": readings_in_words(finding),
    }
