"""Allan deviation against averaging time, a panel per triad, with a slope to compare with."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from procedures.frames import AXES
from station.results.report.noise_figure import DwellNoise, TriadNoise
from station.results.report.svg import AXIS_STYLE, RULE, draw_svg
from station.text.rounding import fixed, power_of_ten


def allan_svg(noise: DwellNoise) -> str:
    """Return the plot: deviations with their 95 % limits as bands, and a line of slope -1/2 (white noise)."""

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, len(noise.triads), squeeze=False)[0]
        for axes, triad in zip(panels, noise.triads, strict=True):
            _panel(axes, triad)

    triads = " and ".join(triad.triad for triad in noise.triads)
    description = f"Allan deviation of {triads} in dwell {noise.dwell}"
    return draw_svg("allan", description, (7.0, 2.9), draw)


def _panel(axes: Axes, noise: TriadNoise) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(which="major", color=RULE, linewidth=0.4, alpha=0.5)
    for axis, curve in zip(AXES, noise.curves, strict=True):
        colour, marker = AXIS_STYLE[axis]
        seen = curve.deviation > 0
        axes.fill_between(
            curve.tau[seen], curve.low[seen], curve.high[seen], color=colour, alpha=0.12, linewidth=0
        )
        axes.plot(
            curve.tau[seen], curve.deviation[seen], color=colour, marker=marker, markersize=3, linewidth=0.9,
            label=f"{noise.triad[0]}{axis}",
        )  # fmt: skip
    _slope(axes, noise)
    axes.set_title(noise.triad.capitalize(), fontsize=9, fontweight="bold", loc="left")
    axes.set_xlabel("averaging time \u03c4 [s]")
    axes.set_ylabel(f"Allan deviation [{noise.unit}]")
    for scale in (axes.xaxis, axes.yaxis):
        scale.set_major_formatter(FuncFormatter(_decade))
        scale.set_minor_formatter(NullFormatter())
    axes.legend(loc="lower left", handlelength=1.6)


def _decade(value: float, _position: int | None = None) -> str:
    exponent = round(float(np.log10(value)))
    return fixed(value, max(-exponent, 0)) if -3 <= exponent <= 3 else power_of_ten(exponent)


def _slope(axes: Axes, noise: TriadNoise) -> None:
    """Draw white noise's slope a little above the curves."""
    tau = noise.curves[0].tau
    level = max(float(np.max(curve.deviation * np.sqrt(tau))) for curve in noise.curves)
    if level <= 0:
        return
    ends = np.array([tau[-1] / 12, tau[-1]])
    above = 2.2 * level / np.sqrt(ends)
    axes.plot(ends, above, color="#57636f", linewidth=1, linestyle=(0, (5, 3)))
    axes.annotate(
        "slope \u2212\u00bd", (ends[0], above[0]), (7, 1), textcoords="offset points", va="bottom", fontsize=7.5
    )
