"""A finding's residual against the coordinate that gave it away: without it on the left, with it on the right."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.frames import AXES
from station.results.diagnosis.finding_residuals import ResidualPanel
from station.results.report.svg import AXIS_STYLE, INK, RULE, draw_svg

SIZE_IN = (7.0, 2.6)
_SPREAD = 0.2  # of a step, by which the three sensors stand apart
_ROWS = {"mean": "dwells", "turn": "turns", "move": "moves", "norm": "rests", "slope": "slopes within dwells",
         "curvature": "curvatures within dwells", "rate": "points of a rate table",
         "soak": "blocks of a soak", "samples": "means of samples"}  # fmt: skip


def residual_svg(number: int, panel: ResidualPanel) -> str:
    """Return the plot of a finding; ``number`` keeps it apart from others on the page."""
    said = f"Residual of the {panel.triad}, {_ROWS.get(panel.kind, panel.kind)}, without and with {panel.effect}"
    return draw_svg(f"finding-{number}", said, SIZE_IN, lambda figure: draw_panel(figure, panel))


def draw_panel(figure: Figure, panel: ResidualPanel) -> None:
    """Draw a finding's residual on an empty figure."""
    unit = panel.unit.replace("ug", "\u00b5g")
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, values, title in ((left, panel.before, "without it"), (right, panel.after, "with it")):
        _draw(axes, panel, values)
        rms = float(np.sqrt(np.mean(values**2)))
        axes.set_title(f"{title}: {rms:.3g} {unit} rms", fontsize=8.5, color=INK, loc="left")
    left.set_ylabel(f"residual [{unit}]")
    handles, labels = left.get_legend_handles_labels()
    if len(labels) > 1:
        figure.legend(handles, labels, loc="outside upper right", ncols=3, handletextpad=0.1)
    figure.supxlabel(panel.coordinate.label, fontsize=8.5, color=INK)


def caption(panel: ResidualPanel) -> str:
    """Return what a plot shows."""
    noise = "a point's scatter" if panel.kind == "rate" else "counting noise"
    return f"{panel.triad.capitalize()}, {_ROWS.get(panel.kind, panel.kind)}; bars: 1\u03c3 of {noise}."


def _draw(axes: Axes, panel: ResidualPanel, values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    axes.axhline(0, color=RULE, linewidth=0.7, zorder=0)
    x = panel.coordinate.values
    for i in (-1, 0, 1, 2):
        rows = panel.axis == i
        if not rows.any():
            continue
        colour, marker = AXIS_STYLE[AXES[i]] if i >= 0 else (INK, "o")
        at = x[rows] + (_SPREAD * (i - 1) if panel.coordinate.names and i >= 0 else 0.0)
        axes.errorbar(
            at, values[rows], panel.sigma[rows], fmt=marker, color=colour, markersize=3.6, elinewidth=0.7,
            label=f"{panel.triad[0]}{AXES[i]}" if i >= 0 else "",
        )  # fmt: skip
    if panel.coordinate.names:
        axes.set_xticks(np.arange(len(panel.coordinate.names)), panel.coordinate.names)
        axes.tick_params(axis="x", labelsize=7 if len(panel.coordinate.names) < 14 else 5, length=0)
