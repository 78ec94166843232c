"""How a guided calibration is run."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from station.files.campaign_setup import Setup

if TYPE_CHECKING:
    from procedures.campaign.plan_steps import Step


@dataclass(frozen=True, slots=True)
class AskedSigmas:
    """What a campaign is to go on for: ``limits`` of the IMU's model, sigmas by name as `station plan` takes them.

    ``noise``: campaigns of the unit that say its noise; else the database is asked.
    """

    limits: bool = False
    sigma: tuple[str, ...] = ()
    noise: tuple[Path, ...] = ()


@dataclass(frozen=True, slots=True)
class CalibrationOptions:
    """Where campaigns go, what the set-up begins with, and the steps if not the usual ones.

    ``wanted``: what a campaign goes on for whose steps are not fixed; None of one whose steps are.
    ``imu_axes``: the cube axes along which the IMU's x, y, z point, the cube's own if empty.

    ``asks``: somebody is there to be asked; ``warms_up``: not before the unit has settled; ``is_patient``:
    whatever goes wrong is said and waited out; else it is raised.
    """

    root: Path
    setup: Setup = field(default_factory=Setup)
    steps: Sequence["Step"] = ()
    asks: bool = True
    warms_up: bool = True
    is_patient: bool = True
    imu_axes: Sequence[str] = ()
    wanted: AskedSigmas | None = None
