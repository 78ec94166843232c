"""A calibration in the words of those who apply it; a line here puts a receiver on the list.

A receiver's file defines ``text``: a `Correction` to the whole file. What it cannot carry it says in comments.
"""

from collections.abc import Callable
from dataclasses import dataclass

from station.files.exports import ardupilot, kalibr, px4
from station.files.exports.correction import Correction, NominalScale, read_correction


@dataclass(frozen=True, slots=True)
class Export:
    """A receiver: its name on the command line, who it is, and how its file is written."""

    name: str
    title: str
    text: Callable[[Correction], str]


EXPORTS = (
    Export("ardupilot", "ArduPilot parameters, NAME,VALUE", ardupilot.text),
    Export("px4", "PX4 parameters as QGroundControl loads them", px4.text),
    Export("kalibr", "Kalibr's imu.yaml, scale-misalignment model", kalibr.text),
)

__all__ = ["EXPORTS", "Correction", "Export", "NominalScale", "read_correction"]
