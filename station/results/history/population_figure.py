"""The charts of a population: every unit in every parameter, and the shift of every group."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from station.results.parameters_by_name import title_of
from station.results.report.svg import INK, PALE, RULE, draw_svg

UNIT, OFF = "#0b5fa5", "#a3231b"
MAX_DEVIATION_SHOWN = 12.0  # sigmas or spreads; what is farther stands at the edge
MAX_GROUPS_SHOWN = 25


# by title the points of a row: distance, and name if it stands out
Rows = list[tuple[str, list[tuple[float, str]]]]


def population_svgs(document: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return heading, remark and ``<svg>`` element of each chart."""
    units, groups = _units(document), _groups(document)
    remark = "Newest calibration of each unit, from the median, in units of the spread of all units. Red: outlier."
    charts = [("Units", remark, _svg("units", "units by parameter", units, "distance from the median [spread]"))]
    if groups:
        remark = (
            f"Shifts in units of their uncertainty, the {len(groups)} least probable of "
            f"{len(document['groups'])}. Red: outlier. With few units, large values are less significant."
        )
        svg = _svg("groups", "shifts by group", groups, "shift [its uncertainty]")
        charts.append(("Cubes, surface plates, sites, operators", remark, svg))
    return charts


def _units(document: dict[str, Any]) -> Rows:
    rows: Rows = []
    for name, track in document["parameters"].items():
        off = {one["serial"] for one in track["extremes"] if one["stands_out"]}
        points = [
            ((one["value"] - track["median"]) / (track.get("spread") or one["std"]),
             one["serial"] if one["serial"] in off else "")
            for one in track["units"]
        ]  # fmt: skip
        rows.append((title_of(name), points))
    return rows


def _groups(document: dict[str, Any]) -> Rows:
    return [
        (f"{one['kind']} {one['id']}: {title_of(one['parameter'])}",
         [(one["shift"] / one["std"], one["id"] if one["stands_out"] else "")])
        for one in document["groups"][:MAX_GROUPS_SHOWN]
    ]  # fmt: skip


def _svg(name: str, description: str, rows: Rows, label: str) -> str:
    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for row, (_, points) in enumerate(rows):
            for distance, who in points:
                _point(axes, row, distance, who)
        axes.axvspan(-2, 2, color=PALE, zorder=0)
        axes.axvline(0, color=RULE, lw=0.7)
        titles = [title for title, _ in rows]
        axes.set(yticks=range(len(rows)), yticklabels=titles, xlabel=label, ylim=(len(rows) - 0.4, -0.6))
        axes.set_xlim(-1.08 * MAX_DEVIATION_SHOWN, 1.08 * MAX_DEVIATION_SHOWN)
        axes.tick_params(axis="y", labelsize=7.5, labelcolor=INK)

    return draw_svg(name, description, (8.6, 1 + 0.23 * len(rows)), draw)


def _point(axes: Axes, row: int, distance: float, name: str) -> None:
    x = min(max(distance, -MAX_DEVIATION_SHOWN), MAX_DEVIATION_SHOWN)
    marker = "o" if x == distance else (">" if distance > 0 else "<")
    axes.plot(x, row, marker, ms=4, color=OFF if name else UNIT, alpha=1 if name else 0.6, lw=0)
    if name:
        axes.annotate(name, (x, row), (-6 if x > 0 else 6, 0), textcoords="offset points", fontsize=7, color=OFF,
                      ha="right" if x > 0 else "left", va="center")  # fmt: skip
