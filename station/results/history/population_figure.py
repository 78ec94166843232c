"""The charts of a population: every unit in every parameter, and the shift of every group."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from station.results.parameters_by_name import title_of
from station.results.report.svg import INK, PALE, RULE, draw_svg

UNIT, OFF = "#0b5fa5", "#a3231b"
MAX_DEVIATION_SHOWN = 12.0  # sigmas or spreads; what is farther stands at the edge
MAX_GROUPS_SHOWN = 25


def population_svgs(document: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return heading, remark and ``<svg>`` element of each chart."""
    charts = [
        (
            "Units",
            "Newest calibration of each unit, from the median, in spreads of the fleet. Red: stands out.",
            draw_svg(
                "units", "units by parameter", (8.6, 1 + 0.23 * len(document["parameters"])), _units(document)
            ),
        )
    ]
    if document["groups"]:
        shown = min(len(document["groups"]), MAX_GROUPS_SHOWN)
        charts.append(
            (
                "Cubes, slabs, sites, operators",
                f"Shifts in their own sigmas, the {shown} least probable of {len(document['groups'])}. "
                "Red: stands out. With few units a sigma counts for less.",
                draw_svg("groups", "shifts by group", (8.6, 1 + 0.23 * shown), _groups(document)),
            )
        )
    return charts


def _units(document: dict[str, Any]) -> Any:
    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for row, track in enumerate(document["parameters"].values()):
            off = {one["serial"] for one in track["extremes"] if one["stands_out"]}
            for one in track["units"]:
                distance = (one["value"] - track["median"]) / (track.get("spread") or one["std"])
                _point(axes, row, distance, one["serial"] if one["serial"] in off else "")
        _rows(axes, [title_of(name) for name in document["parameters"]], "distance from the median [spread]")

    return draw


def _groups(document: dict[str, Any]) -> Any:
    rows = document["groups"][:MAX_GROUPS_SHOWN]

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for row, one in enumerate(rows):
            _point(axes, row, one["shift"] / one["std"], one["id"] if one["stands_out"] else "")
        names = [f"{one['kind']} {one['id']}: {title_of(one['parameter'])}" for one in rows]
        _rows(axes, names, "shift [its own sigma]")

    return draw


def _point(axes: Axes, row: int, distance: float, name: str) -> None:
    x = min(max(distance, -MAX_DEVIATION_SHOWN), MAX_DEVIATION_SHOWN)
    marker = "o" if x == distance else (">" if distance > 0 else "<")
    axes.plot(x, row, marker, ms=4, color=OFF if name else UNIT, alpha=1 if name else 0.6, lw=0)
    if name:
        axes.annotate(name, (x, row), (-6 if x > 0 else 6, 0), textcoords="offset points", fontsize=7, color=OFF,
                      ha="right" if x > 0 else "left", va="center")  # fmt: skip


def _rows(axes: Axes, names: list[str], label: str) -> None:
    axes.axvspan(-2, 2, color=PALE, zorder=0)
    axes.axvline(0, color=RULE, lw=0.7)
    axes.set(yticks=range(len(names)), yticklabels=names, xlabel=label, ylim=(len(names) - 0.4, -0.6))
    axes.set_xlim(-1.08 * MAX_DEVIATION_SHOWN, 1.08 * MAX_DEVIATION_SHOWN)
    axes.tick_params(axis="y", labelsize=7.5, labelcolor=INK)
