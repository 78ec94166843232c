"""Draw the figures of the pages in ``docs``: `python docs/figures/make.py`. Equal code gives equal files."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.cube_motion import manual_rotation
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray, IntArray
from procedures.campaign.plan_steps import turn_steps
from procedures.counts.count_kernels import smooth
from procedures.counts.count_propagation import Nodes, propagate
from procedures.counts.count_rate import estimate_counts
from procedures.diagnosis.diagnose import diagnose
from station.results.diagnosis.finding_figure import SIZE_IN, draw_panel, residual_panels

HERE = Path(__file__).parent
BLUE, ORANGE, GREEN, GREY, PALE = "#1f5a96", "#c4611a", "#3a7d44", "#6b6b6b", "#e4e8ee"
PERIOD, SAMPLES = 0.02, 5000
STYLE = {
    "figure.facecolor": "white", "svg.hashsalt": "fog-station", "font.size": 9, "axes.grid": True,
    "grid.color": "#dddddd", "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False,
}  # fmt: skip


def output(rng: np.random.Generator, rate: float, noise: float, samples: int) -> FloatArray:
    """Return the cumulative output (samples + 1,) [count] of a channel with white rate noise."""
    total: FloatArray = rng.random() + np.concatenate(
        ([0.0], np.cumsum(rate + noise * rng.standard_normal(samples)))
    )
    return total


def slope(increments: IntArray) -> float:
    """Return the least-squares slope of the cumulative count, counts per sample."""
    t = np.arange(len(increments) + 1) - len(increments) / 2
    return float(t @ np.concatenate(([0], np.cumsum(increments))) / (t @ t))


def draw_dwell() -> Figure:
    """Draw one dwell: what the counts allow, what they say, what was true."""
    rate, noise = 7.3 / SAMPLES, 3e-3
    truth = output(np.random.default_rng(12), rate, noise, SAMPLES)
    count = np.floor(truth)
    at = np.arange(SAMPLES + 1) - SAMPLES / 2
    line = rate * at + truth.mean()
    low = count - line
    basis = np.ascontiguousarray((at / SAMPLES)[:, None])
    linked = np.ones(SAMPLES + 1)
    linked[0] = 0.0
    [sites] = propagate([Nodes(at, linked, low, basis[:, 0])], [noise], 60, 1e-3)
    mean, variance, theta, covariance, _ = smooth(at, linked, sites.tau, sites.nu, basis, noise)
    figure, (top, zoom) = plt.subplots(
        1, 2, figsize=(8.6, 3.7), width_ratios=(2.1, 1), layout="constrained", sharey=True
    )
    seconds, std = (at - at[0]) * PERIOD, np.sqrt(variance)
    for axes, part in ((top, slice(0, None, 12)), (zoom, slice(1000, 2050, 5))):
        x = seconds[part]
        axes.fill_between(x, low[part], low[part] + 1, color=PALE, label="allowed: c ≤ output < c + 1")
        axes.plot(x, low[part], color=GREY, lw=0.6)
        axes.plot(x, low[part] + 1, color=GREY, lw=0.6)
        axes.fill_between(
            x, (mean - 2 * std)[part], (mean + 2 * std)[part], color=ORANGE, alpha=0.45, lw=0,
            label="posterior of the path, ± 2 sigma",
        )  # fmt: skip
        axes.plot(x, (truth - line)[part], color=BLUE, lw=0.8, label="true output")
        axes.set_xlabel("time [s]")
    top.plot(
        seconds, theta[0] * at / SAMPLES + mean.mean(), color="black", lw=0.9, ls="--",
        label=f"line found: {theta[0]:+.2f} ± {np.sqrt(covariance[0, 0]):.2f} count per dwell off",
    )  # fmt: skip
    top.set(ylabel="counts less the true line", ylim=(-1.1, 1.75), title="a dwell of 100 s, about 7 counts")
    zoom.set_title("two edges of it")
    top.legend(loc="upper center", ncol=2, fontsize=7.5)
    return figure


def draw_efficiency() -> Figure:
    """Draw the root mean square error over the noise-only bound, by counts per dwell."""
    noise, together, batches = 2e-4, 12, 20
    bound = noise / np.sqrt(SAMPLES)
    counts = np.array([2.4, 3.5, 5.0, 7.5, 11, 17, 27, 45, 80, 150, 300])
    rows = []
    for number, each in enumerate(counts):
        found = []
        for batch in range(batches):
            rng = np.random.default_rng([number, batch])
            rates = each * rng.uniform(0.85, 1.15, together) / SAMPLES
            dwells = [np.diff(np.floor(output(rng, r, noise, SAMPLES))).astype(np.int64) for r in rates]
            for rate, dwell, one in zip(rates, dwells, estimate_counts(dwells, PERIOD), strict=True):
                found.append([one.rate * PERIOD - rate, slope(dwell) - rate, dwell.mean() - rate])
        rows.append(np.sqrt(np.mean(np.array(found) ** 2, axis=0)) / bound)
    figure, axes = plt.subplots(figsize=(6.4, 3.9), layout="constrained")
    names = ("last minus first", "least-squares slope", "interval likelihood, 12 dwells share the noise")
    table = np.array(rows)
    for name, column, colour, mark in zip(names, (2, 1, 0), (GREY, BLUE, ORANGE), "s^o", strict=True):
        axes.loglog(counts, table[:, column], color=colour, marker=mark, ms=4, label=name)
    axes.axhline(1.0, color="black", lw=0.8, ls="--", label="noise alone, if the output were seen uncounted")
    ticks, levels = (2, 5, 10, 20, 50, 100, 300), (1, 2, 5, 10, 20, 50, 100)
    axes.set_xticks(ticks, [str(n) for n in ticks], minor=False)
    axes.set_yticks(levels, [str(n) for n in levels], minor=False)
    axes.minorticks_off()
    axes.set(xlabel="counts in the dwell", ylabel="rms error / noise-only bound", ylim=(0.7, 250))
    axes.set_title("5000 samples, noise 2e-4 count per sample, 240 dwells a point", fontsize=9)
    axes.legend(loc="upper right", fontsize=8)
    return figure


def arrow(
    axes: Axes, begin: FloatArray, direction: FloatArray, text: str, colour: str, off: tuple[float, float]
) -> None:
    """Draw an arrow with its name next to its head."""
    end = begin + direction
    style = {"arrowstyle": "-|>", "color": colour, "lw": 1.5, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=end, xytext=begin, arrowprops=style)
    axes.text(*(end + off), text, color=colour, ha="center", va="center", fontsize=9)


def angle_mark(axes: Axes, at: FloatArray, radius: float, first: float, last: float, text: str) -> None:
    """Draw an arc between two directions [deg] and name the angle."""
    axes.add_patch(Arc((at[0], at[1]), 2 * radius, 2 * radius, theta1=min(first, last), theta2=max(first, last)))
    middle = np.radians((first + last) / 2)
    axes.text(
        *(at + (radius + 0.2) * np.array([np.cos(middle), np.sin(middle)])), text, ha="center", va="center",
        bbox={"facecolor": PALE, "edgecolor": "none", "pad": 0.5},
    )  # fmt: skip


def draw_face_pair() -> Figure:
    """Draw a face pair in the plane of its axis x and one other cube axis y, tilts much exaggerated."""
    up, down = np.radians(17.0), np.radians(9.0)
    # the faces' planes in cube axes (x, y): up is (1, up) resting on one, (-1, down) resting on the other
    corner = np.array([[-1 + np.tan(up), -1], [-1 - np.tan(up), 1], [1 + np.tan(down), 1], [1 - np.tan(down), -1]])
    figure, panels = plt.subplots(1, 3, figsize=(9.0, 3.6), layout="constrained")
    tall = np.array([[0.0, 1.0], [-1.0, 0.0]])  # rotates a vector by -90 deg
    for axes, (angle, base, sign) in zip(panels, ((up, 0, 1), (down, 2, -1)), strict=False):
        normal = np.array([sign * np.cos(angle), np.sin(angle)])
        turn = np.array([tall @ normal, normal])  # takes the cube's axes to those of the page, up being up
        shape = corner @ turn.T
        shape -= [shape[:, 0].mean(), shape[base, 1]]
        centre = shape.mean(axis=0)
        axes.axhspan(-0.5, 0.0, color="#c9c9c9")
        axes.text(0, -0.27, "slab", ha="center", va="center", color="#444444")
        axes.add_patch(Polygon(shape, facecolor=PALE, edgecolor=GREY))
        arrow(axes, centre, np.array([0.0, 1.75]), "up", ORANGE, (0.0, 0.15))
        x_axis = turn @ np.array([1.0, 0.0])
        arrow(axes, centre, 1.45 * x_axis, "x", BLUE, tuple(0.15 * x_axis))
        y_axis = turn @ np.array([0.0, 1.0])
        arrow(axes, centre, 0.95 * y_axis, "y", BLUE, tuple(0.15 * y_axis))
        axis = np.degrees(np.arctan2(*(sign * x_axis)[::-1]))
        if sign < 0:
            axes.plot(*np.stack([centre, centre - 1.3 * x_axis]).T, color=BLUE, lw=0.9, ls=":")
        angle_mark(axes, centre, 0.95, 90.0, axis, r"$a_{up}$" if sign > 0 else r"$a_{down}$")
        axes.set(xlim=(-2.1, 2.1), ylim=(-0.5, 3.35), aspect="equal")
        name = "x up: up vector (1, $a_{up}$)" if sign > 0 else "x down: up vector (-1, $a_{down}$)"
        axes.set_title(f"{name} in (x, y)", fontsize=9)
        axes.axis("off")
    axes = panels[2]
    axes.add_patch(Polygon(corner, facecolor=PALE, edgecolor=GREY))
    left, right = corner[:2].mean(axis=0), corner[2:].mean(axis=0)
    arrow(axes, left, np.array([0.85, 0.85 * np.tan(up)]), "", ORANGE, (0, 0))
    axes.text(left[0] + 0.3, left[1] + 0.4, r"(1, $a_{up}$)", color=ORANGE, ha="center")
    arrow(axes, right, np.array([-0.85, 0.85 * np.tan(down)]), "", ORANGE, (0, 0))
    axes.text(right[0] - 0.5, right[1] + 0.4, r"(-1, $a_{down}$)", color=ORANGE, ha="center")
    mean = (np.tan(up) - np.tan(down)) / 2
    arrow(axes, np.array([-1.75, -0.45]), np.array([3.5, 3.5 * mean]), "", GREEN, (0, 0))
    axes.text(1.62, -0.8, "mean normal\n(1, $q$)", color=GREEN, ha="center")
    axes.text(0.0, 1.5, r"parallelism $p = a_{up} + a_{down}$", ha="center")
    axes.text(0.0, -1.45, r"perpendicularity $q = (a_{up} - a_{down})/2$", ha="center")
    axes.set(xlim=(-2.1, 2.1), ylim=(-1.9, 1.95), aspect="equal")
    axes.set_title("the pair, in the cube's axes", fontsize=9)
    axes.axis("off")
    return figure


def draw_turn() -> Figure:
    """Draw a simulated hand turn: rate, heading, and what is left of the horizontal Earth rate."""
    segment = manual_rotation(
        np.eye(3), np.array([0.0, 0.0, 1.0]), 6 * np.pi, 250, PERIOD, np.random.default_rng(5)
    )
    assert segment.angle is not None
    heading = segment.angle
    t = np.arange(len(heading)) * PERIOD
    rate = np.degrees(np.diff(heading)) / PERIOD
    middle = (heading[1:] + heading[:-1]) / 2
    figure, panels = plt.subplots(3, 1, figsize=(7.2, 5.2), sharex=True, layout="constrained")
    panels[0].plot(t[1:], rate, color=BLUE, lw=1.0)
    panels[0].set(ylabel="rate [deg/s]", title="three turns by hand, 5 s of rest at each end")
    panels[1].plot(t, np.degrees(heading), color=BLUE, lw=1.0, label="heading ψ")
    even = np.interp(t, [5.0, t[-1] - 5.0], [0.0, 1080.0])
    panels[1].plot(t, even, color=GREY, lw=0.9, ls="--", label="at even speed")
    panels[1].set(ylabel="heading [deg]", yticks=(0, 360, 720, 1080))
    panels[1].legend(loc="upper left")
    for values, colour, name in ((np.cos(middle), ORANGE, "cos"), (np.sin(middle), GREEN, "sin")):
        total = np.concatenate(([0.0], np.cumsum(values) * PERIOD))
        panels[2].plot(t, total, color=colour, lw=1.0, label=f"∫ {name} ψ dt, in the end {total[-1]:.2f} s")
    panels[2].set(ylabel="M's terms [s]", xlabel="time [s]")
    panels[2].legend(loc="upper center", ncol=2)
    return figure


def draw_diagnosis() -> Figure:
    """Draw what gave a temperature coefficient away in a simulated campaign."""
    planted = {"accelerometer.bias_temperature": {"x": 1.5e-5, "y": -1e-5, "z": 2e-5}}
    truth = replace(Truth.example(7), temperature_rise_k=5.0, sample_period_s=0.05, effects=planted)
    found = diagnose([simulate_campaign(truth, 3, dwell_s=60.0, turns=turn_steps(3, 5.0), certificate_sigma=2e-7)])
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    draw_panel(figure, residual_panels(found)[0])
    return figure


FIGURES: dict[str, Callable[[], Figure]] = {
    "diagnosis": draw_diagnosis,
    "dwell": draw_dwell,
    "efficiency": draw_efficiency,
    "face_pair": draw_face_pair,
    "turn": draw_turn,
}


def main() -> None:
    """Write every figure as SVG next to this file."""
    mpl.rcParams.update(STYLE)
    for name, draw in FIGURES.items():
        figure = draw()
        figure.savefig(HERE / f"{name}.svg", metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    main()
