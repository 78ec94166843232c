"""The table of commands: a line here puts a command on the list."""

import builtins
from dataclasses import dataclass
from keyword import iskeyword


@dataclass(frozen=True, slots=True)
class Command:
    """A command's name, one line of help, the module that is imported when it is asked for, and its heading."""

    name: str
    help: str
    module: str
    group: str = "Commands"

    @property
    def function(self) -> str:
        """The name of its function; one that Python has taken ends in ``_``."""
        name = self.name.replace("-", "_")
        return f"{name}_" if iskeyword(name) or hasattr(builtins, name) else name


def _under(heading: str, *commands: tuple[str, str] | tuple[str, str, str]) -> tuple[Command, ...]:
    """Return commands of this folder: name, line of help, and the file if it does not have the command's name."""
    return tuple(
        Command(name, line, f"station.commands.{(*file, name.replace('-', '_'))[0]}", heading)
        for name, line, *file in commands
    )


COMMANDS = (
    *_under(
        "Calibrate",
        ("demo", "Calibrate a simulated IMU, to a report and a certificate."),
        ("plan", "Plan the shortest campaign that meets limits."),
        ("calibrate", "Calibrate a live IMU, guided step by step."),
        ("resume", "Continue a campaign that was interrupted.", "calibrate"),
        ("solve", "Solve recorded campaigns for the calibration."),
        ("resolve", "Solve stored campaigns again and compare.", "solve"),
    ),
    *_under(
        "Recordings",
        ("diagnose", "Find errors that the model lacks, in a campaign or any log."),
        ("noise", "Allan deviation, noise terms, spectrum and lines of a recording."),
        ("effects", "Define, try and use error terms of your own."),
        ("apply", "Apply a calibration to a recording, into any format."),
        ("attitude", "Compute roll and pitch along a log."),
        ("tune", "Tune the complementary filter on a log with reference attitude.", "attitude"),
        ("locate", "Compute a trajectory from IMU, GNSS, wheels or a camera."),
    ),
    *_under(
        "Bench",
        ("monitor", "Show roll and pitch of a live device."),
        ("stream", "Send calibrated samples live: Foxglove, UDP, MAVLink, JSON."),
        ("record", "Record what a device sends: raw bytes and counts."),
    ),
    *_under(
        "Results",
        ("report", "Write the report of recorded campaigns.", "solve"),
        ("certificate", "Issue the certificate of a stored calibration."),
        ("history", "List the calibrations of a unit and its drift."),
        ("export", "Write a calibration for a flight stack, Kalibr, C99 or MATLAB."),
        ("verify", "Detect what was changed after it was accepted."),
    ),
    *_under("Fixtures", ("fixtures", "Cubes, surface plates, sites, IMUs and their limits.")),
    *_under(
        "Devices",
        ("devices", "List ports and what each sends, live with --watch."),
        ("simulate", "Serve simulated devices, or a whole bench from a scenario."),
        ("reset-terminal", "Restore a terminal after a screen was killed.", "monitor"),
    ),
)
