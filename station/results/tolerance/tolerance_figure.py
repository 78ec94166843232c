"""The figure of a tolerance study: how many cubes exceed an error, and each item's tolerance or share."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, StrMethodFormatter

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import ITEMS
from procedures.units import UG_PER_G
from station.results.report.svg import INK, PALE, RULE, draw_svg
from station.results.tolerance.tolerance_study import ESTIMATORS, ToleranceStudy

LINES = {"twelve": ("#b8480f", "-"), "two": ("#0b5fa5", "--"), "joint": ("#1f7a4d", "-.")}


def tolerance_svg(found: ToleranceStudy) -> str:
    """Return an SVG file: left the exceedance of every estimator's worst axis, right the items [mm]."""

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
        _exceedance(left, found)
        _items(right, found)

    text = f"Error of the bias over cubes made to the drawing of {found.drawing.cube}, and its tolerance items"
    return draw_svg("tolerance", text, (8.6, 3.5), draw).replace(
        "<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1
    )


def _exceedance(axes: Axes, found: ToleranceStudy) -> None:
    for i, (name, (colour, line)) in enumerate(LINES.items()):
        largest = np.max(np.abs(found.sample.bias[i]), axis=0) * UG_PER_G
        level = np.logspace(-3.5, -0.01, 120)
        axes.plot(np.quantile(largest, 1 - level), 100 * level, line, color=colour, lw=1.4, label=ESTIMATORS[name])
        axes.axvline(float(found.worst[3 * i : 3 * i + 3].max()) * UG_PER_G, color=colour, lw=0.7, ls=line)
    if found.question.wanted is not None:
        axes.axvline(found.question.wanted * UG_PER_G, color=INK, lw=0.9, ls=":")
        axes.annotate("wanted", (found.question.wanted * UG_PER_G, 0.04), rotation=90, ha="right", va="bottom")
    axes.set(xscale="log", yscale="log", ylim=(0.03, 130), xlabel="bias error of the worst axis [ug]")
    axes.set_ylabel("cubes that exceed it [%]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.set_title("thin lines: worst case", fontsize=8, color=INK)
    axes.legend(loc="lower left", fontsize=7.5)


def _items(axes: Axes, found: ToleranceStudy) -> None:
    names, now = list(ITEMS), found.drawing.item * found.drawing.side_mm
    at = np.arange(len(names))
    axes.barh(at, now, height=0.62, color=PALE, edgecolor=RULE, label="now")
    if found.allowed is not None:
        allowed = {one.item: one.allowed * found.drawing.side_mm for one in found.allowed}
        values: FloatArray = np.array([allowed[name] for name in names])
        axes.plot(values, at, "D", ms=4, color=INK, label="allowed")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=2, fontsize=7.5)
    axes.set(yticks=at, yticklabels=names, xlabel="tolerance [mm]")
    axes.invert_yaxis()
