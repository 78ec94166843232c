"""How a guided calibration is run."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from station.files.setup import Setup

if TYPE_CHECKING:
    from procedures.campaign.plan_steps import Step


@dataclass(frozen=True, slots=True)
class CalibrationOptions:
    """Where campaigns go, what the set-up begins with, and the steps if not the usual ones.

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
