"""What is entered in the set-up: labels, units, ranges, and what is wrong with a text, in words.

Ranges are those of a ``campaign.toml`` (`station.files.campaign_folder.campaign_schema`).
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from station.files.campaign_setup import Setup

MAVLINK = "mavlink:udpin:0.0.0.0:14550"
RECEIVER = re.compile(r"mavlink:((udpin|udpout|tcp):(//)?[^?]+:\d{1,5}|serial:(//)?/[^?]+)(\?.+)?")
BARE = re.compile(r"((udp(in|out)?:([^?:\s]+:)?|[^?:\s]+:)\d{1,5}|(/dev/|tty)[^?]+)(\?.+)?")  # made a URL of later
TextCheck = Callable[[str], str]  # returns what is wrong, or nothing
MISSING = "is required:"  # begins what is said of a field yet to be typed, unless another field is why


def number(
    low: float, high: float, unit: str = "", *, is_needed: bool = False, is_whole: bool = False
) -> TextCheck:
    """Return the check of a number between two limits."""
    expected = f"{'a whole number' if is_whole else 'a number'} from {low:g} to {high:g} {unit}".rstrip()

    def check(text: str) -> str:
        if not text:
            return f"{MISSING} {expected}" if is_needed else ""
        try:
            value = float(text)
        except ValueError:
            return f"{text!r} is not a number, expected {expected}"
        if not low <= value <= high or math.isnan(value) or (is_whole and value != int(value)):
            return f"{text} is out of range, expected {expected}"
        return ""

    return check


def receiver(text: str) -> str:
    """Check the address of a GNSS receiver, as far as a screen can; options are judged when it is opened."""
    if not text or RECEIVER.fullmatch(text) or BARE.fullmatch(text):
        return ""
    return f"{text!r} is no receiver, expected {MAVLINK}, udpout or tcp likewise, or mavlink:serial:/dev/NAME"


@dataclass(frozen=True, slots=True)
class Entry:
    """A field of the set-up: the name in `Setup`, its label, its unit, its check, and what an empty one means."""

    name: str
    label: str
    unit: str = ""
    check: TextCheck = lambda _: ""
    empty: str = ""


ENTRIES = (
    Entry("url", "Address", empty="/dev/ttyUSB0?format=counts, HOST:PORT, can0 ..."),
    Entry("model", "Model", empty="from the device"),
    Entry("serial", "Serial no.", empty="from the device"),
    Entry("gnss", "GNSS", check=receiver, empty=f"none, or as {MAVLINK}"),
    Entry("latitude_deg", "Latitude", "deg", number(-90, 90, "deg", is_needed=True), "needed, or GNSS"),
    Entry("longitude_deg", "Longitude", "deg", number(-180, 360, "deg"), "not needed"),
    Entry("height_m", "Height", "m", number(-1000, 20000, "m"), "sea level"),
    Entry("operator", "Operator"),
    Entry("gravity_m_s2", "Surveyed g", "m/s2", number(9.5, 10.1, "m/s2"), "from the height"),
    Entry("gravity_std_m_s2", "its u", "m/s2", number(1e-9, 1, "m/s2"), "1e-05"),
    Entry("dwell_s", "Dwell", "s", number(0, 7200, "s", is_needed=True), "0: from noise"),
    Entry("bias_ug", "Bias u", "ug", number(1e-3, 1e4, "ug"), "if dwell is 0"),
    Entry("revolutions", "Turns", "each", number(1, 100, is_needed=True, is_whole=True)),
    Entry("repeats", "Repeat 1st", "times", number(0, 9, is_needed=True, is_whole=True)),
)


def texts_of(setup: Setup) -> dict[str, str]:
    """Return a set-up as the texts of its fields; empty where nothing is chosen."""
    values = setup.model_dump()
    return {entry.name: _text(values[entry.name]) for entry in ENTRIES}


def problems(texts: Mapping[str, str]) -> dict[str, str]:
    """Return what is wrong, by field, in the order of the form; empty when the campaign can begin."""
    found = {entry.name: problem for entry in ENTRIES if (problem := entry.check(texts[entry.name]))}
    if texts["gnss"] and not texts["latitude_deg"]:
        del found["latitude_deg"]  # the receiver says it
    if not texts["url"]:
        found = {"url": f"{MISSING} choose a port or type the device's address", **found}
    if texts["gravity_std_m_s2"] and not texts["gravity_m_s2"]:
        found["gravity_m_s2"] = "is required with its uncertainty"
    if "dwell_s" not in found and float(texts["dwell_s"]) == 0 and not texts["bias_ug"]:
        found["bias_ug"] = "is required when the dwell is 0: it determines the dwell time"
    return found


def setup_of(texts: Mapping[str, str], remembered: Setup) -> Setup:
    """Return the set-up that checked texts say; what has no field is as remembered, what is empty by default."""
    kept = remembered.model_dump(exclude={entry.name for entry in ENTRIES})
    return Setup.model_validate(kept | {name: text for name, text in texts.items() if text})


def seconds_needed(dwell_s: float, dwells: int) -> float:
    """Return about how long a campaign takes [s]: 45 s of handling for each dwell, 6 turns of a minute."""
    return dwells * (dwell_s + 45) + 6 * 60


def _text(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.15g}" if isinstance(value, float) else str(value)
