"""The bench of `carried_cube` as the engine knows it: site, care and noise of the units drawn there."""

import numpy as np

from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from procedures.frames import AXES
from procedures.planning.campaign_design import CampaignDesign, of_positions
from procedures.planning.design_sigmas import DesignSigmas, WantedSigmas, wanted
from procedures.planning.step_information import StepInformation, UnitNoise
from procedures.positions import ATTITUDES
from tests.procedures.twelve_positions.carried_cube import ARW, DRIFT_DEG_S, HEADING, LATITUDE, SEAT

ARCSEC = np.pi / 180 / 3600
OFF_DIAGONAL = [4, 5, 6, 8, 9, 10]  # of E, in k, E, D
K, E, D = slice(0, 3), OFF_DIAGONAL, slice(12, 15)
HALVES = "ENU ESD WND WSU UEN DWN DSW USE NUE NDW SDE SUW".split()
PAIRS = [(a, b) for a in AXES for b in AXES if a != b]


def bench(noise: UnitNoise, closure_deg: float = 0.01) -> DesignSigmas:
    """The bench of `carried_cube` with a unit of this noise."""
    care = ProcedureSigma(HEADING, float(np.radians(closure_deg)), seat=SEAT)
    site = Site(LATITUDE, 9.80665, 1e-9)
    return DesignSigmas(StepInformation(Campaign("M", "S", True, site, (), (), care, Fixture()), noise))


def unit(accel_white: float = 1e-5 * np.sqrt(0.02), instability: float = DRIFT_DEG_S) -> UnitNoise:
    """A unit of 1000 count/(g s) and 36000 count/deg; accelerometers of 10 ug a sample of 20 ms."""
    return UnitNoise(np.full(3, accel_white), np.full(3, ARW), np.full(3, 1e3), np.full(3, 36e3), instability)


def order(letters: list[str], seconds: float = 100.0) -> CampaignDesign:
    """Dwells where the cube's x, y, z point along ``letters``."""
    return of_positions([ATTITUDES.index(each) + 1 for each in letters], seconds)


def gyroscopes(k: float = 0.0, misalignment: float = 0.0, bias: float = 0.0) -> WantedSigmas:
    """What is wanted of the gyroscopes, what is nought aside: relative, rad, deg/h."""
    names = {f"scale_factor.{a}": k for a in AXES} | {f"bias.{a}": bias for a in AXES}
    names |= {f"misalignment.{a}{b}": misalignment for a, b in PAIRS}
    return wanted({f"gyroscope.{name}": sigma for name, sigma in names.items() if sigma})


def accelerometer_bias(sigma: float) -> WantedSigmas:
    """The same of the accelerometers' bias [g]."""
    return wanted({f"accelerometer.bias.{a}": sigma for a in AXES})


def rms(values: np.ndarray) -> float:
    """The root mean square."""
    return float(np.sqrt(np.mean(values**2)))
