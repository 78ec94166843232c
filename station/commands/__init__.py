"""The commands of `station`, one file each; a line here puts a command on the list.

A command's file defines a function of the command's name (``-`` written ``_``) with typer annotations and a
`Database` option. It imports what is heavy inside that function, not at its top. A folder with a table
``COMMANDS`` of its own is a group of commands.
"""

import builtins
from dataclasses import dataclass
from keyword import iskeyword
from typing import Annotated

import typer


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


COMMANDS = (
    Command(
        "demo", "Calibrate a simulated IMU, to a report and a certificate.", "station.commands.demo", "Calibrate"
    ),
    Command("plan", "Plan the shortest campaign that meets limits.", "station.commands.plan", "Calibrate"),
    Command("calibrate", "Calibrate a live IMU, guided step by step.", "station.commands.calibrate", "Calibrate"),
    Command("resume", "Continue a campaign that was interrupted.", "station.commands.resume", "Calibrate"),
    Command("solve", "Solve recorded campaigns for the calibration.", "station.commands.solve", "Calibrate"),
    Command("resolve", "Solve stored campaigns again and compare.", "station.commands.resolve", "Calibrate"),
    Command(
        "diagnose",
        "Find errors that the model lacks, in a campaign or any log.",
        "station.commands.diagnose",
        "Recordings",
    ),
    Command(
        "noise",
        "Allan deviation, noise terms, spectrum and lines of a recording.",
        "station.commands.noise",
        "Recordings",
    ),
    Command("effects", "Define, try and use error terms of your own.", "station.commands.effects", "Recordings"),
    Command(
        "apply", "Apply a calibration to a recording, into any format.", "station.commands.apply", "Recordings"
    ),
    Command("attitude", "Compute roll and pitch along a log.", "station.commands.attitude", "Recordings"),
    Command(
        "tune",
        "Tune the complementary filter on a log with reference attitude.",
        "station.commands.tune",
        "Recordings",
    ),
    Command(
        "locate",
        "Compute a trajectory from IMU, GNSS, wheels or a camera.",
        "station.commands.locate",
        "Recordings",
    ),
    Command("monitor", "Show roll and pitch of a live device.", "station.commands.monitor", "Bench"),
    Command(
        "stream", "Send calibrated samples live: Foxglove, UDP, MAVLink, JSON.", "station.commands.stream", "Bench"
    ),
    Command("record", "Record what a device sends: raw bytes and counts.", "station.commands.record", "Bench"),
    Command("report", "Write the report of recorded campaigns.", "station.commands.report", "Results"),
    Command(
        "certificate", "Issue the certificate of a stored calibration.", "station.commands.certificate", "Results"
    ),
    Command("history", "List the calibrations of a unit and its drift.", "station.commands.history", "Results"),
    Command(
        "export",
        "Write a calibration for a flight stack, Kalibr, C99 or MATLAB.",
        "station.commands.export",
        "Results",
    ),
    Command("verify", "Detect what was changed after it was accepted.", "station.commands.verify", "Results"),
    Command(
        "fixtures", "Cubes, surface plates, sites, IMUs and their limits.", "station.commands.fixtures", "Fixtures"
    ),
    Command(
        "devices", "List ports and what each sends, live with --watch.", "station.commands.devices", "Devices"
    ),
    Command(
        "simulate",
        "Serve simulated devices, or a whole bench from a scenario.",
        "station.commands.simulate",
        "Devices",
    ),
    Command(
        "reset-terminal",
        "Restore a terminal after a screen was killed.",
        "station.commands.reset_terminal",
        "Devices",
    ),
)

Database = Annotated[
    str | None,  # not a Path, which would make one slash of the four in sqlite:////var/lib/station.db
    typer.Option(
        "--db", envvar="STATION_DB", metavar="FILE", help="SQLite file, or URL, of fixtures and calibrations."
    ),
]
