"""Matplotlib figures as inline SVG: text stays text, equal figures give equal bytes."""

import html
import io
import re
from collections.abc import Callable
from math import log10

import matplotlib.style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from station.text import fixed, power_of_ten

INK, RULE, PALE = "#1b2733", "#9aa5b1", "#e9edf1"
AXIS_STYLE = {  # colour and symbol both show the axis: readable in grey and by the colour-blind
    "x": ("#0b5fa5", "o"),
    "y": ("#b8480f", "s"),
    "z": ("#1f7a4d", "^"),
}
_STYLE = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 8.5,
    "axes.edgecolor": RULE,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
}
DPI = 160  # of a PNG
_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def draw_svg(name: str, description: str, size_in: tuple[float, float], draw: Callable[[Figure], None]) -> str:
    """Return what ``draw`` puts on an empty figure as an ``<svg>`` element for HTML.

    ``name`` keeps its ids apart from other figures' on the page, ``description`` is for those who cannot see it.
    The user's matplotlib configuration has no influence.
    """
    buffer = io.StringIO()
    with matplotlib.style.context(["default", {**_STYLE, "svg.hashsalt": name}]):
        figure = Figure(figsize=size_in, layout="constrained")
        draw(figure)
        # not `savefig`, which draws a laid-out figure twice: once for the layout, once for the file
        FigureCanvasSVG(figure).print_svg(buffer, metadata=_NO_METADATA)  # type: ignore[no-untyped-call]
    text = buffer.getvalue()
    element = text[text.index("<svg") :]
    for prefix in (r'\bid="', r'\bhref="#', r"url\(#"):
        element = re.sub(prefix, lambda match: f"{match[0]}{name}-", element)
    element = re.sub(r' (?:width|height)="[\d.]+pt"', "", element, count=2)
    element = re.sub(r' xmlns(?::xlink)?="[^"]*"', "", element).replace("xlink:href", "href")
    return element.replace("<svg", f'<svg role="img" aria-label="{html.escape(description)}"', 1)


def draw_png(size_in: tuple[float, float], draw: Callable[[Figure], None]) -> bytes:
    """Return what ``draw`` puts on an empty figure as PNG, whatever the user's matplotlib configuration."""
    buffer = io.BytesIO()
    with matplotlib.style.context(["default", _STYLE]):
        figure = Figure(figsize=size_in, dpi=DPI, layout="constrained", facecolor="white")
        draw(figure)
        FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": None})  # type: ignore[no-untyped-call]
    return buffer.getvalue()


def log_axes(axes: Axes, xlabel: str, ylabel: str, title: str = "") -> None:
    """Make both axes logarithmic, with a grid at powers of ten."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(which="major", color=RULE, linewidth=0.4, alpha=0.5)
    axes.set_title(title, fontsize=9, fontweight="bold", loc="left", y=1.0)  # nothing above
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel.replace("ug", "\u00b5g"))
    for scale in (axes.xaxis, axes.yaxis):
        scale.set_major_formatter(FuncFormatter(_decade))
        scale.set_minor_formatter(NullFormatter())


def _decade(value: float, _position: int | None = None) -> str:
    exponent = round(float(log10(value)))
    return fixed(value, max(-exponent, 0)) if -3 <= exponent <= 3 else power_of_ten(exponent)
