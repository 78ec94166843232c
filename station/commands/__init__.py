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
    """A command's name, one line of help, and the module that is imported when it is asked for."""

    name: str
    help: str
    module: str

    @property
    def function(self) -> str:
        """The name of its function; one that Python has taken ends in ``_``."""
        name = self.name.replace("-", "_")
        return f"{name}_" if iskeyword(name) or hasattr(builtins, name) else name


COMMANDS = (
    Command("demo", "Run the main job on simulated devices, to a report at the end.", "station.commands.demo"),
    Command("simulate", "Serve simulated devices, or a whole bench from a scenario.", "station.commands.simulate"),
    Command("devices", "List ports and what each sends, live with --watch.", "station.commands.devices"),
    Command("record", "Record what a device sends: raw bytes and counts.", "station.commands.record"),
    Command("plan", "Plan the campaign that meets limits in the least time.", "station.commands.plan"),
    Command("calibrate", "Run a calibration campaign on a live device.", "station.commands.calibrate"),
    Command("resume", "Resume a campaign that was left or killed.", "station.commands.resume"),
    Command("solve", "Solve recorded campaigns for a calibration with 1 sigma.", "station.commands.solve"),
    Command("diagnose", "Find what the residual says the model lacks.", "station.commands.diagnose"),
    Command("effects", "Effects of your own: write, try, put in force.", "station.commands.effects"),
    Command("noise", "Allan deviation, its terms, spectrum and lines of a recording.", "station.commands.noise"),
    Command("report", "Write the calibration report of recorded campaigns.", "station.commands.report"),
    Command("certificate", "Issue the certificate of a stored calibration.", "station.commands.certificate"),
    Command("history", "List the stored calibrations of a unit and its drift.", "station.commands.history"),
    Command("resolve", "Solve recordings again with today's code; what changed?", "station.commands.resolve"),
    Command("apply", "Apply a calibration to a log or recording, into any format.", "station.commands.apply"),
    Command("stream", "Hand on calibrated samples live: Foxglove, UDP, MAVLink, JSON.", "station.commands.stream"),
    Command("monitor", "Watch roll and pitch of a live device.", "station.commands.monitor"),
    Command("attitude", "Roll and pitch along a log, by any aid.", "station.commands.attitude"),
    Command("tune", "Choose the mixing law's gains from a log with truth.", "station.commands.tune"),
    Command("export", "Write a calibration for a flight stack or Kalibr.", "station.commands.export"),
    Command("locate", "Locate a recording: IMU, GNSS and odometry to a trajectory.", "station.commands.locate"),
    Command("fixtures", "Cubes, slabs, sites, IMUs and their limits.", "station.commands.fixtures"),
    Command("reset-terminal", "Restore a terminal after a screen was killed.", "station.commands.reset_terminal"),
    Command("verify", "Find what was altered since it was accepted.", "station.commands.verify"),
)

Database = Annotated[
    str | None,  # not a Path, which would make one slash of the four in sqlite:////var/lib/station.db
    typer.Option(
        "--db", envvar="STATION_DB", metavar="FILE", help="SQLite file, or URL, of fixtures and calibrations."
    ),
]
