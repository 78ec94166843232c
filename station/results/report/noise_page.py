"""A `noise/1` as one page: Allan deviation and spectrum (two panels for each triad), terms, lines."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.frames import TRIADS
from procedures.statistics.allan_deviation import noise_shapes
from station.files.atomic_file import replace_file
from station.results.html_templates import html_template
from station.results.report.noise_document import (
    MAX_LINES_IN_WORDS,
    condition_texts,
    is_undetermined,
    line_text,
    units_of,
)
from station.results.report.svg import AXIS_STYLE, draw_png, draw_svg, log_axes
from station.text import significant

WIDTH_IN, ROW_IN = 7.0, 2.7
DIGITS = 2  # of a term, whose interval is some percent

Channels = Sequence[Mapping[str, Any]]


def noise_svg(name: str, channels: Channels) -> str:
    """Return the plot as an ``<svg>`` element; empty without channels."""
    if not channels:
        return ""
    rows = _by_triad(channels)
    text = f"Allan deviation and spectrum of {', '.join(each['channel'] for each in channels)}"
    return draw_svg(name, text, (WIDTH_IN, ROW_IN * len(rows)), lambda figure: _draw(figure, rows))


def write_noise_png(path: Path, channels: Channels) -> None:
    """Write the plot as PNG.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    rows = _by_triad(channels)
    replace_file(path, draw_png((WIDTH_IN, ROW_IN * max(len(rows), 1)), lambda figure: _draw(figure, rows)))


def _by_triad(channels: Channels) -> list[Channels]:
    rows = [[each for each in channels if each["channel"].startswith(triad)] for triad in TRIADS]
    return [row for row in rows if row]


def _draw(figure: Figure, rows: Sequence[Channels]) -> None:
    for row, (left, right) in zip(rows, figure.subplots(len(rows), 2, squeeze=False), strict=True):
        for each in row:
            _allan(left, each)
            _spectrum(right, each)
        triad, unit = row[0]["channel"].split()[0], row[0]["allan"]["unit"]
        log_axes(left, "averaging time \u03c4 [s]", f"Allan deviation [{unit}]", triad.capitalize())
        log_axes(right, "frequency [Hz]", f"density [{unit}/\u221aHz]")
        left.legend(loc="best", handlelength=1.6)
        _widen(right)


def _widen(axes: Axes) -> None:
    """Show a decade at the least, so that an axis has numbers."""
    low, high = axes.get_ylim()
    if high < 30 * low:
        axes.set_ylim(np.sqrt(low * high / 30), np.sqrt(low * high * 30))


def _allan(axes: Axes, channel: Mapping[str, Any]) -> None:
    colour, marker = AXIS_STYLE[channel["channel"][-1]]
    curve = {name: np.array(channel["allan"][name]) for name in ("tau_s", "deviation", "low", "high")}
    axes.fill_between(curve["tau_s"], curve["low"], curve["high"], color=colour, alpha=0.12, linewidth=0)
    axes.plot(
        curve["tau_s"], curve["deviation"], color=colour, marker=marker, markersize=2.6, linewidth=0,
        label=channel["channel"][-1],
    )  # fmt: skip
    axes.plot(curve["tau_s"], _fitted(channel, curve["tau_s"]), color=colour, linewidth=0.9)


def _fitted(channel: Mapping[str, Any], tau: np.ndarray[Any, np.dtype[np.float64]]) -> Any:
    """Return the deviation that the terms with a value make."""
    scaled = units_of(channel["channel"].split()[0], True)
    units = scaled if channel["allan"]["unit"] == scaled.unit else units_of("", False)
    shapes, total = noise_shapes(tau), np.zeros_like(tau)
    for name, term in channel["terms"].items():
        total += (shapes[name] * (term.get("value") or 0.0) / units.terms[name][3]) ** 2
    return np.where(total > 0, np.sqrt(total), np.nan)


def _spectrum(axes: Axes, channel: Mapping[str, Any]) -> None:
    colour, marker = AXIS_STYLE[channel["channel"][-1]]
    hertz, density = np.array(channel["spectrum"]["hertz"]), np.array(channel["spectrum"]["density"])
    seen = density > 0
    axes.plot(hertz[seen], np.sqrt(density[seen]), color=colour, linewidth=0.8)
    for line in channel["lines"]:
        at = int(np.argmin(abs(hertz - line["hertz"])))
        if density[at] > 0:
            axes.plot(
                line["hertz"], np.sqrt(density[at]), color=colour, marker=marker, markersize=4, fillstyle="none"
            )


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
    tables = [_triad_table(row) for row in _by_triad(channels)]
    return html_template("noise_section.html").render(plot=Markup(noise_svg("noise", channels)), tables=tables)


def _triad_table(channels: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the rows of a triad's table: a term each, its cells, its unit; and the lines found."""
    rows = [
        (term["name"], term["symbol"], [_cell(each["terms"][name]) for each in channels], term["unit"])
        for name, term in channels[0]["terms"].items()
    ]
    return {
        "triad": channels[0]["channel"].split()[0],
        "axes": [each["channel"].split()[1] for each in channels],
        "recordings": sorted({f"{each['seconds']:.4g} s of {each['recording']}" for each in channels}),
        "rows": rows,
        "conditions": [(each["channel"], text) for each in channels for text in condition_texts(each)],
        "lines": [
            (each["channel"], line_text(line)) for each in channels for line in each["lines"][:MAX_LINES_IN_WORDS]
        ],
    }


def _cell(term: Mapping[str, Any]) -> tuple[str, str]:
    """Return a term's value, or what stands in its place, and its interval."""
    if is_undetermined(term):
        return "not determined", ""
    if "below" in term:
        return f"< {significant(term['below'], DIGITS)}", ""
    value, low, high = (significant(term[key], DIGITS) for key in ("value", "low", "high"))
    return value, f"[{low}, {high}]"
