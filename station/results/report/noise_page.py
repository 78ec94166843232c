"""A `noise/1` as one page: Allan deviation and spectrum (two panels for each triad), terms, lines."""

from collections.abc import Sequence
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
from station.results.report.noise_document import NoiseChannel, NoiseDocument, Term, units_of
from station.results.report.svg import AXIS_STYLE, draw_png, draw_svg, log_axes

WIDTH_IN, ROW_IN = 7.0, 2.7

Channels = Sequence[NoiseChannel]


def noise_svg(name: str, channels: Channels) -> str:
    """Return the plot as an ``<svg>`` element; empty without channels."""
    if not channels:
        return ""
    rows = _by_triad(channels)
    text = f"Allan deviation and spectrum of {', '.join(each.channel for each in channels)}"
    return draw_svg(name, text, (WIDTH_IN, ROW_IN * len(rows)), lambda figure: _draw(figure, rows))


def write_noise_png(path: Path, channels: Channels) -> None:
    """Write the plot as PNG; raise `CannotWrite` if the place cannot be written."""
    rows = _by_triad(channels)
    replace_file(path, draw_png((WIDTH_IN, ROW_IN * max(len(rows), 1)), lambda figure: _draw(figure, rows)))


def _by_triad(channels: Channels) -> list[Channels]:
    rows = [[each for each in channels if each.triad == triad] for triad in TRIADS]
    return [row for row in rows if row]


def _draw(figure: Figure, rows: Sequence[Channels]) -> None:
    for row, (left, right) in zip(rows, figure.subplots(len(rows), 2, squeeze=False), strict=True):
        for each in row:
            _allan(left, each)
            _spectrum(right, each)
        unit = row[0].allan.unit
        log_axes(left, "averaging time \u03c4 [s]", f"Allan deviation [{unit}]", row[0].triad.capitalize())
        log_axes(right, "frequency [Hz]", f"density [{unit}/\u221aHz]")
        left.legend(loc="best", handlelength=1.6)
        _widen(right)


def _widen(axes: Axes) -> None:
    """Show a decade at the least, so that an axis has numbers."""
    low, high = axes.get_ylim()
    if high < 30 * low:
        axes.set_ylim(np.sqrt(low * high / 30), np.sqrt(low * high * 30))


def _allan(axes: Axes, channel: NoiseChannel) -> None:
    (colour, marker), curve, tau = AXIS_STYLE[channel.axis], channel.allan, np.array(channel.allan.tau_s)
    axes.fill_between(tau, curve.low, curve.high, color=colour, alpha=0.12, linewidth=0)
    axes.plot(tau, curve.deviation, color=colour, marker=marker, markersize=2.6, linewidth=0, label=channel.axis)
    axes.plot(tau, _fitted(channel, tau), color=colour, linewidth=0.9)


def _fitted(channel: NoiseChannel, tau: np.ndarray[Any, np.dtype[np.float64]]) -> Any:
    """Return the deviation that the terms with a value make."""
    scaled = units_of(channel.triad, True)
    units = scaled if channel.allan.unit == scaled.unit else units_of("", False)
    shapes, total = noise_shapes(tau), np.zeros_like(tau)
    for name, term in channel.terms.items():
        if isinstance(term, Term) and term.value is not None:
            total += (shapes[name] * term.value / units.terms[name][3]) ** 2
    return np.where(total > 0, np.sqrt(total), np.nan)


def _spectrum(axes: Axes, channel: NoiseChannel) -> None:
    colour, marker = AXIS_STYLE[channel.axis]
    hertz, density = np.array(channel.spectrum.hertz), np.array(channel.spectrum.density)
    seen = density > 0
    axes.plot(hertz[seen], np.sqrt(density[seen]), color=colour, linewidth=0.8)
    for line in channel.lines:
        at = int(np.argmin(abs(hertz - line.hertz)))
        if density[at] > 0:
            axes.plot(
                line.hertz, np.sqrt(density[at]), color=colour, marker=marker, markersize=4, fillstyle="none"
            )


def write_noise_page(path: Path, document: NoiseDocument) -> None:
    """Write the noise as one self-contained HTML file; raise `CannotWrite` if the place cannot be written."""
    section, page = Markup(noise_section(document.channels)), html_template("noise_page.html")
    replace_file(path, page.render(origin=document.provenance, section=section, document=document).encode())


def noise_section(channels: Channels) -> str:
    """Return plot and tables of the channels as a piece of HTML; empty without any."""
    if not channels:
        return ""
    plot = Markup(noise_svg("noise", channels))
    return html_template("noise_section.html").render(plot=plot, triads=_by_triad(channels))
