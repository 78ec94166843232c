"""Options of a guided calibration and of the engine's process; the last set-up, kept with the user's settings."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs
from pydantic import ValidationError

from drivers.addresses import with_absolute_paths
from station.errors import cannot_write
from station.files.atomic_file import replace_file
from station.files.campaign_setup import Setup
from station.guide.setup_view import FrozenValue
from station.guide.view import OperatorCommand

if TYPE_CHECKING:
    from procedures.campaign.plan_steps import Step
    from station.guide.simulated_operator import SimulatedOperator

TREMOR_SEED = 1


class TargetUncertainties(FrozenValue):
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
    errors are reported and waited out; else they are raised.
    """

    root: Path
    setup: Setup = field(default_factory=Setup)
    steps: Sequence["Step"] = ()
    asks: bool = True
    warms_up: bool = True
    is_patient: bool = True
    imu_axes: Sequence[str] = ()
    wanted: TargetUncertainties | None = None


class EngineOptions(FrozenValue):
    """Options of the engine's process: as `CalibrationOptions`, with files by their names.

    ``hands`` is the control address of a simulated device whose cube is then moved without a person; ``first``
    is executed at once.
    """

    root: Path
    database: str | None = None
    setup: Setup = Setup()
    plan: Path | None = None
    asks: bool = True
    warms_up: bool = True
    hands: str | None = None
    move_s: float = 45.0
    tremor: bool = False
    wanted: TargetUncertainties | None = None
    first: OperatorCommand | None = None

    def engine(self) -> CalibrationOptions:
        """Return the engine's options; raise `DataRefused` if the plan cannot be read."""
        options = CalibrationOptions(self.root, self.setup, (), self.asks, self.warms_up, wanted=self.wanted)
        if self.plan is None:
            return options
        from station.files.campaign_folder import plan_file

        return replace(options, steps=plan_file.read_plan(self.plan), imu_axes=plan_file.read_mounting(self.plan))

    def operator(self) -> "SimulatedOperator | None":
        """Return who moves the cube, None where a person does."""
        if not self.hands:
            return None
        from drivers.simulated.bench_control import BenchControl
        from station.guide.simulated_operator import HandlingStyle, SimulatedOperator

        style = HandlingStyle(TREMOR_SEED, wrong_share=0.0) if self.tremor else None
        return SimulatedOperator(BenchControl(self.hands), self.move_s, style)


def setup_file() -> Path:
    """Return where the last set-up is kept: the user's configuration, or the folder ``STATION_CONFIG`` names."""
    folder = os.environ.get("STATION_CONFIG")
    return (Path(folder) if folder else platformdirs.user_config_path("fog-station")) / "setup.json"


def load_setup() -> Setup:
    """Return the last set-up; the default one where there is none or it cannot be read."""
    try:
        return Setup.model_validate_json(setup_file().read_bytes())
    except (OSError, ValidationError):
        return Setup()


def from_anywhere(setup: Setup) -> Setup:
    """Return a set-up whose addresses mean the same in any folder."""
    gnss = with_absolute_paths(setup.gnss, "receiver")
    return setup.model_copy(update={"url": with_absolute_paths(setup.url), "gnss": gnss})


def save_setup(setup: Setup) -> None:
    """Remember a set-up; raise `CannotWrite` if the place cannot be written."""
    path = setup_file()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path.parent, error) from error
    replace_file(path, (from_anywhere(setup).model_dump_json(indent=1) + "\n").encode())
