"""Starts the engine's process, and ends it with whoever started it."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from procedures.error_codes import ErrorCode
from station.errors import StationError
from station.files.campaign_setup import Setup
from station.guide.command import OperatorCommand
from station.guide.setup_view import FrozenValue

if TYPE_CHECKING:
    from station.guide.options import CalibrationOptions
    from station.guide.simulated_operator import SimulatedOperator

TREMOR_SEED = 1
END_S = 30.0  # a solve under way, and a reader's farewell


class EngineFailed(StationError):
    """The engine's process ended as it should not: a bug."""

    code = ErrorCode.BUG

    def __init__(self, exit_code: int, said: str) -> None:
        self.exit_code, self.said = exit_code, said
        last = said.strip().splitlines()[-1:] or [f"exit code {exit_code}"]
        super().__init__(
            f"the recording program has stopped: {last[0]}; all accepted steps are safe, see `station resume`. "
            "Report this bug"
        )


class EngineOptions(FrozenValue):
    """What the engine's process is told: as `station.guide.options.CalibrationOptions`, with files by their names.

    ``until_limits``, ``sigma`` and ``noise`` say what a campaign goes on for whose steps are not fixed.
    ``hands`` is the control address of a simulated device whose cube is then moved without a person; ``first``
    is obeyed at once.
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
    until_limits: bool = False
    sigma: tuple[str, ...] = ()
    noise: tuple[Path, ...] = ()
    first: OperatorCommand | None = None

    def engine(self) -> "CalibrationOptions":
        """Return the engine's options; raise `DataRefused` if the plan cannot be read."""
        from station.guide.options import AskedSigmas, CalibrationOptions

        options = CalibrationOptions(self.root, self.setup, (), self.asks, self.warms_up)
        if self.until_limits or self.sigma:
            return replace(options, wanted=AskedSigmas(self.until_limits, self.sigma, self.noise))
        if self.plan is None:
            return options
        from station.files.campaign_folder import plan_file

        return replace(options, steps=plan_file.read_plan(self.plan), imu_axes=plan_file.read_mounting(self.plan))

    def operator(self) -> "SimulatedOperator | None":
        """Return who moves the cube, None where a person does."""
        if not self.hands:
            return None
        from drivers.simulated.bench_control import BenchControl
        from station.guide.hand_style import HandStyle
        from station.guide.simulated_operator import SimulatedOperator

        style = HandStyle(TREMOR_SEED, wrong_share=0.0) if self.tremor else None
        return SimulatedOperator(BenchControl(self.hands), self.move_s, style)


@contextmanager
def engine_process(options: EngineOptions) -> Iterator[Path]:
    """Yield the path of the socket of an engine that lives as long as the ``with`` lasts."""
    with tempfile.TemporaryDirectory(prefix="station-") as folder:  # mode 0700
        socket, said = Path(folder) / "engine", Path(folder) / "stderr"
        with said.open("w") as errors, subprocess.Popen(
            [sys.executable, "-P", "-m", "station.guide", str(socket)],
            stdin=subprocess.PIPE, stderr=errors, text=True,  # a screen has the terminal to itself
            start_new_session=True,  # Ctrl-C is for the screen
        ) as process:  # fmt: skip
            assert process.stdin is not None
            try:
                process.stdin.write(options.model_dump_json() + "\n")
                process.stdin.flush()
                yield socket
            finally:
                process.stdin.close()
                try:
                    process.wait(END_S)
                except subprocess.TimeoutExpired:
                    process.kill()  # it waits for something of its own; what was accepted is on the disk
                if process.returncode:  # None where it was killed
                    raise EngineFailed(process.returncode, said.read_text())
