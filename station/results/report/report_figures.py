"""The plots of a report: the residuals of every step over sigma."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.calibration.solution_values import StepResidual
from procedures.frames import AXES, TRIADS
from station.results.report.result_tables import LIMIT_SIGMAS, NOTICE_SIGMAS, normalised
from station.results.report.svg import AXIS_STYLE, INK, PALE, RULE, draw_svg

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


def residual_plots(residuals: Sequence[StepResidual]) -> list[tuple[str, Markup]]:
    """Return each triad that has residuals, and these as an ``<svg>`` element."""
    drawn = ((triad, residual_svg(triad, residuals)) for triad in TRIADS)
    return [(triad, Markup(svg)) for triad, svg in drawn if svg]
