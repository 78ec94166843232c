"""Draw the figures of measured data: `STATION_DATA=.../data python docs/figures/make_measured.py`.

Residuals alone are drawn; the data stay where they are, under their own licences.
"""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS
from procedures.effects.excitation import Excitation
from procedures.evidence.linear_model import fit_linear
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.paths import DATA

HERE = Path(__file__).parent
STYLE = {
    "figure.facecolor": "white", "svg.hashsalt": "fog-station", "font.size": 9, "axes.grid": True,
    "grid.color": "#dddddd", "axes.spines.top": False, "axes.spines.right": False,
}  # fmt: skip
STAGES = (
    ("linear", ()),
    ("with scale_nonlinearity", ("gyroscope.scale_nonlinearity",)),
    ("with scale_temperature too", ("gyroscope.scale_nonlinearity", "gyroscope.scale_temperature")),
)


def left_by(campaign: Campaign, names: tuple[str, ...]) -> tuple[FloatArray, Excitation]:
    """Return the residual (n,) [deg/s] that effects of some names leave, and what was seen."""
    found = diagnose([campaign], [each for each in EFFECTS if each.name in names])
    fit = fit_linear(found.evidence, [each.term for each in found.added])
    return fit.white * fit.factor * found.evidence.sigma, found.evidence.excitation


def draw_fog() -> Figure:
    """Draw what a real FOG's rate table leaves, effect by effect, by rate and temperature."""
    campaign = read_campaign(DATA / "measured/fog_rate_temperature").campaign
    figure, panels = plt.subplots(1, 3, figsize=(9.0, 3.0), layout="constrained")
    for axes, (title, names) in zip(panels, STAGES, strict=True):
        residual, seen = left_by(campaign, names)
        dots = axes.scatter(seen.omega[:, 2], residual, c=seen.temperature, s=4, cmap="plasma", rasterized=True)
        axes.set_title(f"{title}\n{np.std(residual):.3g} deg/s rms", fontsize=8.5, loc="left")
        axes.set_xlabel("rate [deg/s]")
    panels[0].set_ylabel("residual [deg/s]")
    figure.colorbar(dots, ax=panels[-1], label="temperature [degC]")
    return figure


def main() -> None:
    """Write the figures as PNG next to this file."""
    mpl.rcParams.update(STYLE)
    draw_fog().savefig(HERE / "measured_fog.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
