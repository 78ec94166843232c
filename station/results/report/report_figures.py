"""The plots of a report: residuals over sigma, and the Allan deviation of the longest dwell, all six channels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.calibration.solution_values import Solution, StepResidual, TriadCalibration
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.counts.sample_records import CountSeries
from procedures.frames import AXES, TRIADS
from procedures.statistics.allan_deviation import (
    MIN_SAMPLES,
    AllanDeviation,
    NoiseTerm,
    noise_terms,
    overlapping_deviation,
)
from station.results.report.noise_document import units_of
from station.results.report.result_tables import LIMIT_SIGMAS, NOTICE_SIGMAS, normalised
from station.results.report.svg import AXIS_STYLE, INK, PALE, RULE, draw_svg, log_axes
from station.text import significant


@dataclass(frozen=True, slots=True, eq=False)
class TriadNoise:
    """A triad's three curves in ``unit`` and what is read off them.

    ``rows`` has name, symbol and unit of each noise term, and its value and interval per axis, or a bound.
    """

    triad: str
    unit: str
    curves: tuple[AllanDeviation, ...]
    rows: list[tuple[str, str, str, list[str]]]


@dataclass(frozen=True, slots=True)
class DwellNoise:
    """Which dwell was used, how long its longest gap-free part is [s], and the triads' noise."""

    dwell: str
    seconds: float
    triads: tuple[TriadNoise, ...]


def longest_dwell_noise(campaigns: Sequence[Campaign], solution: Solution) -> DwellNoise | None:
    """Return the noise of the dwell with the longest gap-free part, None if there is no dwell long enough."""
    dwells = [(_longest_part(dwell), dwell) for campaign in campaigns for dwell in campaign.dwells]
    if not dwells:
        return None
    part, dwell = max(dwells, key=lambda pair: (pair[0].stop - pair[0].start) * pair[1].series.period)
    if part.stop - part.start < MIN_SAMPLES:
        return None
    triads = [
        _triad(name, dwell, part, calibration)
        for name, calibration in (("gyroscope", solution.gyroscope), ("accelerometer", solution.accelerometer))
    ]
    seconds = (part.stop - part.start) * dwell.series.period
    return DwellNoise(dwell.name, seconds, tuple(triad for triad in triads if triad is not None))


def _longest_part(dwell: DwellRecord) -> slice:
    edges = np.append(dwell.series.starts, len(dwell.series))
    longest = int(np.argmax(np.diff(edges)))
    return slice(int(edges[longest]), int(edges[longest + 1]))


def _triad(name: str, dwell: DwellRecord, part: slice, calibration: TriadCalibration | None) -> TriadNoise | None:
    series = dwell.series
    output = series.gyro if name == "gyroscope" else series.accel
    if output is None:
        return None
    counts = isinstance(series, CountSeries)
    units = units_of(name, calibration is not None)
    factor, unit = np.ones(3), "count/s" if counts else units.unit
    if calibration is not None:
        factor, unit = units.factor / calibration.scale_factor.value, units.unit
    if counts:
        factor = factor / series.period
    curves = tuple(
        overlapping_deviation(output[part, i] * abs(np.float64(factor[i])), series.period) for i in range(3)
    )
    quantum = abs(factor) * series.period if counts else np.zeros(3)
    found = [noise_terms(curve, float(one)) for curve, one in zip(curves, quantum, strict=True)]
    rows = [
        (title, symbol, shown, [_cell(one[key], scale) for one in found])
        for key, (title, symbol, shown, scale) in (units.terms if calibration is not None else {}).items()
    ]
    return TriadNoise(name, unit, curves, rows)


def _cell(term: NoiseTerm, scale: float) -> str:
    if term.value is None:
        return f"< {significant(term.high * scale)}"
    low, high = significant(term.low * scale), significant(term.high * scale)
    return f"{significant(term.value * scale)} [{low}, {high}]"


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
    log_axes(axes, "averaging time \u03c4 [s]", f"Allan deviation [{noise.unit}]", noise.triad.capitalize())
    axes.legend(loc="lower left", handlelength=1.6)


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


_AXIS_OFFSET = 0.22  # how far apart the three axes of a step stand


def residual_svg(triad: str, residuals: Sequence[StepResidual]) -> str:
    """Return the plot of a triad's residuals / sigma with lines at 2 and 4 sigma; empty if it has none."""
    chosen = [r for r in residuals if r.triad == triad]
    if not chosen:
        return ""
    ratio = np.array([normalised(r) for r in chosen])
    greatest = float(np.max(np.nan_to_num(np.abs(ratio))))

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        _limits(axes, max(5.0, 1.1 * greatest))
        for i, axis in enumerate(AXES):
            colour, marker = AXIS_STYLE[axis]
            at = np.arange(len(chosen)) + (i - 1) * _AXIS_OFFSET
            axes.vlines(at, 0, ratio[:, i], color=colour, linewidth=0.8, alpha=0.55)
            axes.plot(
                at, ratio[:, i], marker, color=colour, markersize=4.2, linestyle="none", label=f"{triad[0]}{axis}"
            )
        axes.set_xticks(np.arange(len(chosen)), [_tick(r) for r in chosen])
        axes.tick_params(axis="x", length=0)
        axes.set_xlim(-0.6, len(chosen) - 0.4)
        axes.set_xlabel(
            "position of a dwell"
            + (", axis of a turn" if any(r.kind == "turn" for r in chosen) else "")
            + (", m: a move" if any(r.kind == "move" for r in chosen) else "")
        )
        axes.set_ylabel("residual / \u03c3")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=3, handletextpad=0.1)

    steps = len(chosen)
    description = f"Residuals of the {triad} over their sigma, {steps} steps, greatest {greatest:.1f}"
    return draw_svg(f"residual-{triad}", description, (7.0, 2.35), draw)


def _limits(axes: Axes, greatest: float) -> None:
    axes.axhspan(-NOTICE_SIGMAS, NOTICE_SIGMAS, color=PALE, zorder=0, linewidth=0)
    axes.axhline(0, color=RULE, linewidth=0.7)
    for sigmas, dash in ((NOTICE_SIGMAS, (0, (4, 3))), (LIMIT_SIGMAS, "solid")):
        for side in (-1, 1):
            axes.axhline(side * sigmas, color=INK, linewidth=0.7, linestyle=dash, zorder=1)
        label = f"\u00b1{sigmas:g}\u03c3" + (" limit" if sigmas == LIMIT_SIGMAS else "")
        axes.annotate(
            label, (1.0, sigmas), (3, 0), axes.get_yaxis_transform(), "offset points", va="center", fontsize=7.5
        )
    axes.set_ylim(-greatest, greatest)


def _tick(residual: StepResidual) -> str:
    if residual.kind == "move":
        return "m"
    if residual.kind != "turn":
        return str(residual.position)
    name = residual.name.removesuffix(".csv").removesuffix(".mcap").removeprefix("turn_")
    return name.replace("_plus", "+").replace("_minus", "\u2212")


def allan_plot(noise: DwellNoise | None) -> Markup:
    """Return the Allan deviation as an ``<svg>`` element; empty where there is none."""
    return Markup(allan_svg(noise)) if noise is not None and noise.triads else Markup("")


def residual_plots(residuals: Sequence[StepResidual]) -> list[tuple[str, Markup]]:
    """Return each triad that has residuals, and these as an ``<svg>`` element."""
    drawn = ((triad, residual_svg(triad, residuals)) for triad in TRIADS)
    return [(triad, Markup(svg)) for triad, svg in drawn if svg]
