"""Draw the figures of locate.md: `STATION_DATA=.../data python docs/figures/make_locate.py`."""

import tempfile
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.arrays import FloatArray
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.imu_source import by_imu
from station.locate.locate_folder import by_odometry, distances
from station.locate.outer_layer import Located
from tests.benchmarks.kitti import write_kitti
from tests.benchmarks.locate import OUTAGE, SILENT, drawn
from tests.paths import DATA

HERE = Path(__file__).parent
STYLE = {
    "figure.facecolor": "white", "svg.hashsalt": "fog-station", "svg.fonttype": "none", "font.size": 9,
    "axes.grid": True, "grid.color": "#dddddd", "axes.spines.top": False, "axes.spines.right": False,
}  # fmt: skip
BLUE, ORANGE, PALE = "#1f5a96", "#c4611a", "#b8c4d0"


def draw_outage() -> Figure:
    """Draw a track through an outage, and error and sigma of two sources through theirs."""
    by_track = drawn(read_fusion(DATA / "fusion/v201_outage"), 0, gap=OUTAGE)
    by_force = drawn(read_fusion(DATA / "fusion/mh03_inertial"), 0, gap=SILENT)
    figure, panels = plt.subplots(1, 3, figsize=(10.0, 3.3), layout="constrained")
    _track(panels[0], by_track, located := by_odometry(by_track))
    _honest(panels[1], by_track, located, OUTAGE, "SVO's odometry, V201, 20 s without GNSS")
    _honest(panels[2], by_force, by_imu(by_force), SILENT, "IMU alone, MH03, 10 s without GNSS")
    return figure


def _track(axes: Axes, log: FusionLog, located: Located) -> None:
    p, out = located.online.p, (located.online.t > OUTAGE[0]) & (located.online.t < OUTAGE[1])
    axes.plot(*log.fixes.p_n[::4, :2].T, ".", color=PALE, ms=2, label="GNSS")
    axes.plot(*p[:, :2].T, color=BLUE, lw=1.0, label="online")
    axes.plot(*p[out, :2].T, color=ORANGE, lw=1.8, label="without GNSS")
    axes.set(xlabel="East [m]", ylabel="North [m]", aspect="equal")
    axes.set_title("the track", fontsize=9, loc="left")
    axes.legend(fontsize=7, loc="lower right")


def _honest(axes: Axes, log: FusionLog, located: Located, gap: tuple[float, float], title: str) -> None:
    assert log.truth is not None
    assert located.covariance is not None
    t, near = located.online.t, (located.online.t > gap[0] - 15) & (located.online.t < gap[1] + 15)
    error = distances(located.online, log.truth)
    sigma = np.sqrt(np.trace(located.covariance[:, :3, :3], axis1=1, axis2=2))
    axes.axvspan(*gap, color="#f0f0f0", zorder=0)
    axes.plot(t[near], error[near], color=BLUE, lw=1.2, label="error, online")
    axes.plot(t[near], sigma[near], color=ORANGE, lw=1.2, ls="--", label="its own 1 sigma, of three axes")
    axes.set(xlabel="time [s]", ylabel="[m]", ylim=(0, 1.3 * float(sigma[near].max())))
    axes.set_title(title, fontsize=9, loc="left")
    axes.legend(fontsize=7, loc="upper left")


def draw_kitti() -> Figure:
    """Draw KITTI by every tenth fix, and how far the others are from it."""
    with tempfile.TemporaryDirectory() as there:
        held = write_kitti(Path(there), 10)
        log = read_fusion(Path(there))
    located = by_imu(log)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 3.6), layout="constrained")
    left.plot(*located.smoothed.p[:, :2].T, color=BLUE, lw=1.0, label="smoothed")
    left.plot(*log.fixes.p_n[:, :2].T, "o", color=ORANGE, ms=3.5, label="fixes used")
    left.set(xlabel="East [m]", ylabel="North [m]", aspect="equal")
    left.legend(fontsize=7)
    t = held[(held[:, 0] > located.smoothed.t[0]) & (held[:, 0] < located.smoothed.t[-1])]
    for trajectory, colour, name in ((located.online, PALE, "online"), (located.smoothed, BLUE, "smoothed")):
        right.semilogy(t[:, 0], _off(t, trajectory.t, trajectory.p), ".", color=colour, ms=4, label=name)
    for time in log.fixes.t:
        right.axvline(time, color=ORANGE, lw=0.4, alpha=0.5, zorder=0)
    right.set(xlabel="time [s], lines: fixes used", ylabel="distance of the other fixes [m]")
    right.legend(fontsize=7)
    return figure


def _off(held: FloatArray, t: FloatArray, p: FloatArray) -> FloatArray:
    at = np.stack([np.interp(held[:, 0], t, p[:, i], np.nan, np.nan) for i in range(3)], axis=1)
    off: FloatArray = np.linalg.norm(held[:, 1:] - at, axis=1)
    return off


def main() -> None:
    """Write the figures as PNG next to this file."""
    mpl.rcParams.update(STYLE)
    for name, draw in (("locate_outage", draw_outage), ("locate_kitti", draw_kitti)):
        draw().savefig(HERE / f"{name}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
