"""history/1 or population/1 as one self-contained page."""

from itertools import groupby
from typing import Any

from markupsafe import Markup

from station.results.history.population_figure import population_svgs
from station.results.history.population_text import population_text
from station.results.history.unit_history_figure import history_svg
from station.results.history.unit_history_text import history_text
from station.results.html_templates import html_template


def history_page(document: dict[str, Any]) -> str:
    """Return the page's HTML; equal documents give equal text."""
    if document["format"] == "history/1":
        title, text = f"History of {document['serial']}", history_text(document)
        charts = [chart for one in document["analysis"] for chart in _charts(one)]
        effects = [row for one in document["calibrations"] for row in _effects(one)]
    else:
        title, text = f"All units of {document['model']}", population_text(document)
        charts, effects = population_svgs(document), []
    figures = [(heading, remark, Markup(svg)) for heading, remark, svg in charts]
    return html_template("history.html").render(title=title, charts=figures, effects=effects, text=text)


def _effects(calibration: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return when it was accepted, name and hash of the file of each effect of a calibration's model."""
    when = calibration["accepted_utc"][:16].replace("T", " ")
    return [(when, name, sha256) for name, sha256 in calibration.get("effects", {}).items()]


_REMARK = (
    "Bars: 95 % interval of the calibration. Shaded: 95 % interval of the value at a later turn-on. Dotted: "
    "limits. Below: z with control limits (dashed), its moving average (black) with its own (grey); red: out of "
    "control."
)


def _charts(one: dict[str, Any]) -> list[tuple[str, str, str]]:
    named = groupby(one["parameters"], key=lambda name: name.rpartition(".")[0])
    return [
        (
            f"{one['model']}: {kind.replace('_', ' ').replace('.', ' ')}",
            _REMARK,
            history_svg(kind, {name: one["parameters"][name] for name in names}, one["control_limit"]),
        )
        for kind, names in named
    ]
