"""A `noise/1` as one page: the plot, the terms as a table, the lines."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from procedures.frames import TRIADS
from station.files.atomic_file import replace_file
from station.results.html_templates import html_template
from station.results.noise.noise_plot import noise_svg
from station.results.noise.noise_text import MAX_LINES_SAID, condition_texts, is_undetermined, line_text


def write_noise_page(path: Path, document: Mapping[str, Any]) -> None:
    """Write the noise as one self-contained HTML file.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    section = Markup(noise_section(document["channels"]))
    page = html_template("noise_page.html")
    replace_file(path, page.render(origin=document["provenance"], section=section, document=document).encode())


def noise_section(channels: Sequence[Mapping[str, Any]]) -> str:
    """Return plot and tables of the channels as a piece of HTML; empty without any."""
    if not channels:
        return ""
    triads = [_triad([each for each in channels if each["channel"].startswith(triad)]) for triad in TRIADS]
    tables = [each for each in triads if each["axes"]]
    return html_template("noise_section.html").render(plot=Markup(noise_svg("noise", channels)), tables=tables)


def _triad(channels: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the rows of a triad's table: a term each, its cells, its unit; and the lines found."""
    rows = [
        (term["name"], term["symbol"], [_cell(each["terms"][name]) for each in channels], term["unit"])
        for name, term in (channels[0]["terms"].items() if channels else ())
    ]
    return {
        "axes": [each["channel"] for each in channels],
        "recordings": sorted({f"{each['seconds']:.4g} s of {each['recording']}" for each in channels}),
        "rows": rows,
        "conditions": [(each["channel"], text) for each in channels for text in condition_texts(each)],
        "lines": [
            (each["channel"], line_text(line)) for each in channels for line in each["lines"][:MAX_LINES_SAID]
        ],
    }


def _cell(term: Mapping[str, Any]) -> str:
    if is_undetermined(term):
        return "not determined"
    if "below" in term:
        return f"< {term['below']:.3g}"
    return f"{term['value']:.3g} [{term['low']:.3g}, {term['high']:.3g}]"
