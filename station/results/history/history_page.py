"""The history of a unit, or all units of a model, as one self-contained page with charts."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure

from station.results.history.population import Population, population_text
from station.results.history.unit_history import ModelHistory, ParameterHistory, UnitHistory
from station.results.history.unit_history_text import history_text
from station.results.html_templates import html_template
from station.results.parameters_by_name import shown_scale, title_of
from station.results.report.result_tables import NORMAL_95
from station.results.report.svg import INK, PALE, RULE, draw_svg

COLUMNS = 3
FAN_ROOM = 2.0  # times the range of the values, above and below: a wider prediction is cut off
VALUE, AHEAD, ALARM, LIMIT = "#0b5fa5", "#8fb4d6", "#a3231b", "#b8480f"


def history_svg(kind: str, found: Sequence[ParameterHistory], control: float) -> str:
    """Return the charts of the parameters of one kind (``accelerometer.bias``) as an ``<svg>`` element."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots(2 * rows, COLUMNS, squeeze=False, sharex=True, height_ratios=[1.7, 1] * rows)
        for i, track in enumerate(found):
            row, column = divmod(i, COLUMNS)
            draw_values(axes[2 * row, column], track)
            _control(axes[2 * row + 1, column], track, control)
        for row in range(rows):
            axes[2 * row, 0].set_ylabel("value")
            axes[2 * row + 1, 0].set_ylabel("z")
        for empty in axes.ravel()[2 * COLUMNS * rows :]:
            empty.remove()

    rows = -(-len(found) // COLUMNS)
    text = f"{title_of(kind)} over calibrations, with prediction and control chart"
    return draw_svg(kind.replace(".", "-").replace("_", "-"), text, (8.6, 3.7 * rows), draw)


def draw_values(axes: Axes, track: ParameterHistory) -> None:
    """Draw a parameter's values in its own unit for people, with limits and prediction."""
    scale, unit = shown_scale(track.name, track.unit)
    value, std = np.array(track.value) * scale, np.array(track.std) * scale
    when = _days(track.measured_utc)
    axes.errorbar(when, value, NORMAL_95 * std, fmt="o", ms=3, lw=0, elinewidth=1, capsize=2, color=VALUE)
    if track.prediction is not None:
        low, high = axes.get_ylim()
        days = _days([row[0] for row in track.prediction.fan])
        ahead = np.array([row[1:] for row in track.prediction.fan]) * scale
        axes.fill_between(days, ahead[:, 1], ahead[:, 2], color=PALE, edgecolor=AHEAD, lw=0.7)
        axes.plot(days, ahead[:, 0], "--", color=AHEAD, lw=1)
        _scale(axes, low, high)
    _limits(axes, track.limits or {}, scale)
    axes.set_title(f"{track.axis} [{unit}]", fontsize=8.5, loc="left")
    axes.ticklabel_format(axis="y", useOffset=False)
    _dates(axes)


def _scale(axes: Axes, low: float, high: float) -> None:
    """Let the prediction widen what the values take, ``low`` to ``high``, but not beyond where they are a line."""
    now, room = axes.get_ylim(), FAN_ROOM * (high - low)
    axes.set_ylim(max(now[0], low - room), min(now[1], high + room))


def _limits(axes: Axes, ends: dict[str, float], scale: float) -> None:
    """Draw the limits that lie near the values: one far away would make all else a line."""
    low, high = axes.get_ylim()
    near = [end * scale for end in ends.values() if low - 2 * (high - low) < end * scale < high + 2 * (high - low)]
    for end in near:
        axes.axhline(end, color=LIMIT, lw=1, ls=":")
    if ends and not near:
        axes.annotate("limits beyond", (0.99, 0.02), xycoords="axes fraction", ha="right", fontsize=7, color=LIMIT)


def _control(axes: Axes, track: ParameterHistory, control: float) -> None:
    axes.axhline(0, color=RULE, lw=0.7)
    if (chart := track.chart) is None:
        axes.annotate("too few calibrations", (0.5, 0.5), xycoords="axes fraction", ha="center", color=RULE)
        axes.set_yticks([])
    else:
        when, z = _days(track.measured_utc)[-len(chart.z) :], np.array(chart.z)
        for sign in (-1, 1):
            axes.axhline(sign * control, color=LIMIT, lw=1, ls="--")
            axes.plot(when, sign * np.array(chart.ewma_limit), color=RULE, lw=0.8)
        alarm = [sha256 in chart.alarms for sha256 in track.calibrations[-len(z) :]]
        axes.plot(when, chart.ewma, color=INK, lw=1)
        axes.scatter(when, z, s=11, c=[ALARM if one else VALUE for one in alarm], marker="o", zorder=3)
    _dates(axes)


def _days(moments: list[str]) -> Any:
    return np.array([one.removesuffix("Z") for one in moments], dtype="datetime64[s]")


def _dates(axes: Axes) -> None:
    locator = AutoDateLocator(minticks=2, maxticks=4)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator, show_offset=False))  # type: ignore[no-untyped-call]
    axes.tick_params(axis="both", labelsize=7)


UNIT, OFF = "#0b5fa5", "#a3231b"
MAX_DEVIATION_SHOWN = 12.0  # sigmas or spreads; what is farther stands at the edge
MAX_GROUPS_SHOWN = 25


# by title the points of a row: distance, and name if it stands out
Rows = list[tuple[str, list[tuple[float, str]]]]


def population_svgs(found: Population) -> list[tuple[str, str, str]]:
    """Return heading, remark and ``<svg>`` element of each chart."""
    units, groups = _units(found), _groups(found)
    remark = "Newest calibration of each unit, from the median, in units of the spread of all units. Red: outlier."
    charts = [("Units", remark, _svg("units", "units by parameter", units, "distance from the median [spread]"))]
    if groups:
        remark = (
            f"Shifts in units of their uncertainty, the {len(groups)} least probable of {len(found.groups)}. Red: "
            "outlier. With few units, large values are less significant."
        )
        svg = _svg("groups", "shifts by group", groups, "shift [its uncertainty]")
        charts.append(("Cubes, surface plates, sites, operators", remark, svg))
    return charts


def _units(found: Population) -> Rows:
    rows: Rows = []
    for name, track in found.parameters.items():
        off = {one.serial for one in track.extremes if one.stands_out}
        points = [
            ((one.value - track.median) / (track.spread or one.std), one.serial if one.serial in off else "")
            for one in track.units
        ]
        rows.append((title_of(name), points))
    return rows


def _groups(found: Population) -> Rows:
    return [
        (f"{one.kind} {one.id}: {title_of(one.parameter)}",
         [(one.shift / one.std, one.id if one.stands_out else "")])
        for one in found.groups[:MAX_GROUPS_SHOWN]
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


def unit_page(history: UnitHistory) -> str:
    """Return a unit's page; equal histories give equal text."""
    charts = [chart for one in history.analysis for chart in _charts(one)]
    effects = [(one.accepted, *effect) for one in history.calibrations for effect in (one.effects or {}).items()]
    return _page(f"History of {history.serial}", charts, history_text(history), effects)


def population_page(found: Population) -> str:
    """Return the page of all units of a model; equal populations give equal text."""
    return _page(f"All units of {found.model}", population_svgs(found), population_text(found))


def _page(
    title: str, charts: Sequence[tuple[str, str, str]], text: str, effects: Sequence[tuple[str, str, str]] = ()
) -> str:
    figures = [(heading, remark, Markup(svg)) for heading, remark, svg in charts]
    return html_template("history.html").render(title=title, charts=figures, effects=effects, text=text)


_REMARK = (
    "Bars: 95 % interval of the calibration. Shaded: 95 % interval of the value at a later turn-on. Dotted: "
    "limits. Below: z with control limits (dashed), its moving average (black) with its own (grey); red: out of "
    "control."
)


def _charts(one: ModelHistory) -> Iterator[tuple[str, str, str]]:
    for kind, tracks in groupby(one.parameters.values(), attrgetter("kind")):
        yield f"{one.model}: {title_of(kind)}", _REMARK, history_svg(kind, list(tracks), one.control_limit)
