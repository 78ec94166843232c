"""The charts of a unit's parameters: above the values with limits and prediction, below the control chart."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure

from station.results.parameters_by_name import shown_scale, title_of
from station.results.report.parameter_tables import NORMAL_95
from station.results.report.svg import INK, PALE, RULE, draw_svg

COLUMNS = 3
FAN_ROOM = 2.0  # times the range of the values, above and below: a wider prediction is cut off
VALUE, AHEAD, ALARM, LIMIT = "#0b5fa5", "#8fb4d6", "#a3231b", "#b8480f"


def history_svg(kind: str, found: Mapping[str, dict[str, Any]], control: float) -> str:
    """Return the charts of the parameters of one kind (``accelerometer.bias``) as an ``<svg>`` element."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots(2 * rows, COLUMNS, squeeze=False, sharex=True, height_ratios=[1.7, 1] * rows)
        for i, (name, track) in enumerate(found.items()):
            row, column = divmod(i, COLUMNS)
            draw_values(axes[2 * row, column], name, track)
            _control(axes[2 * row + 1, column], track, control)
        for row in range(rows):
            axes[2 * row, 0].set_ylabel("value")
            axes[2 * row + 1, 0].set_ylabel("z")
        for empty in axes.ravel()[2 * COLUMNS * rows :]:
            empty.remove()

    rows = -(-len(found) // COLUMNS)
    said = f"{title_of(kind)} over calibrations, with prediction and control chart"
    return draw_svg(kind.replace(".", "-").replace("_", "-"), said, (8.6, 3.7 * rows), draw)


def draw_values(axes: Axes, name: str, track: dict[str, Any]) -> None:
    """Draw a parameter's values in its own unit for people, with limits and prediction."""
    scale, unit = shown_scale(name, track["unit"])
    value, std = (np.array(track[key]) * scale for key in ("value", "std"))
    when = _days(track["measured_utc"])
    axes.errorbar(when, value, NORMAL_95 * std, fmt="o", ms=3, lw=0, elinewidth=1, capsize=2, color=VALUE)
    if "prediction" in track:
        low, high = axes.get_ylim()
        fan = track["prediction"]["fan"]
        ahead = np.array([row[1:] for row in fan]) * scale
        axes.fill_between(
            _days([row[0] for row in fan]), ahead[:, 1], ahead[:, 2], color=PALE, edgecolor=AHEAD, lw=0.7
        )
        axes.plot(_days([row[0] for row in fan]), ahead[:, 0], "--", color=AHEAD, lw=1)
        _scale(axes, low, high)
    _limits(axes, track.get("limits", {}), scale)
    axes.set_title(f"{name.rpartition('.')[2]} [{unit}]", fontsize=8.5, loc="left")
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


def _control(axes: Axes, track: dict[str, Any], control: float) -> None:
    axes.axhline(0, color=RULE, lw=0.7)
    if (chart := track.get("chart")) is None:
        axes.annotate("too few calibrations", (0.5, 0.5), xycoords="axes fraction", ha="center", color=RULE)
        axes.set_yticks([])
    else:
        when, z = _days(track["measured_utc"])[-len(chart["z"]) :], np.array(chart["z"])
        for sign in (-1, 1):
            axes.axhline(sign * control, color=LIMIT, lw=1, ls="--")
            axes.plot(when, sign * np.array(chart["ewma_limit"]), color=RULE, lw=0.8)
        alarm = [sha256 in chart["alarms"] for sha256 in track["calibrations"][-len(z) :]]
        axes.plot(when, chart["ewma"], color=INK, lw=1)
        axes.scatter(when, z, s=11, c=[ALARM if one else VALUE for one in alarm], marker="o", zorder=3)
    _dates(axes)


def _days(moments: list[str]) -> Any:
    return np.array([one.removesuffix("Z") for one in moments], dtype="datetime64[s]")


def _dates(axes: Axes) -> None:
    locator = AutoDateLocator(minticks=2, maxticks=4)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator, show_offset=False))  # type: ignore[no-untyped-call]
    axes.tick_params(axis="both", labelsize=7)
