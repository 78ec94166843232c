"""The measurement that would separate an error term from what it is mistaken for: by what its record says of it.

Steps complement the campaign that was diagnosed: both are then diagnosed together, ``station diagnose FIRST
SECOND``. What cannot be written as steps is reported in words; the others are files of `plan/1`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import wrap
from typing import Any

from procedures.effects import CATALOGUE
from procedures.effects.effect import MeasurementName
from procedures.frames import AXES
from procedures.positions import POSITIONS, face_of
from station.files.atomic_file import replace_file
from station.files.campaign_folder.plan_file import FORMAT
from station.files.toml_file import toml_text

WIDTH = 100  # of a plan's remarks
DWELL_S, LONG_S, SOAK_S = 100.0, 600.0, 3600.0
SLOW_DEG_S, REVOLUTIONS = 12.0, 3  # a hand turns at about 35 deg/s unless specified
OTHER_SPEEDS_DEG_S = {"+": 55.0, "-": 100.0}  # beyond that of a hand, for the form of a curve
FREE = 12  # more than the K2 and the cross products of three axes
MIXED = (1, 9, 6, 12, 4, 7, 2, 10, 5, 11, 3, 8)  # every flip between other faces than in 1..12


@dataclass(frozen=True, slots=True)
class Measurement:
    """What to measure: in words, and its steps by kind as `plan/1` has them; ``imu_axes`` if re-mounted."""

    name: str
    say: str
    steps: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    imu_axes: tuple[str, ...] = ()

    @property
    def phrase(self) -> str:
        """The words as part of a sentence."""
        return f"{self.say[0].lower()}{self.say[1:].rstrip('.')}"


def remounted(imu_axes: Sequence[str], about: str) -> Measurement:
    """Return the twelve positions with the IMU turned by 90 deg about an axis of the cube.

    One mounting leaves open what lies along its own axis; two, about two axes, leave nothing.
    """
    axes = turned(imu_axes, about)
    say = (
        f"Mount the IMU turned by 90 deg about the cube's {about}, so that its x, y, z point along the cube's "
        f"{', '.join(axes)}, and record the twelve positions: errors of the cube then appear in another channel. "
        f"Two such mountings are needed, about two axes. A face certificate or free positions near 45 deg "
        f"separate them too."
    )
    return Measurement(f"remounted_about_{about}", say, positions(range(1, 13)), axes)


def again(where: Mapping[str, Any]) -> Measurement:
    """Return the positions that stood out and their pair partners, once more."""
    named = where.get("position", [])
    found = [p for p in (named if isinstance(named, list) else [named]) if p in range(1, len(POSITIONS) + 1)]
    wanted = dict.fromkeys(q for p in found for q in (p, partner(p)))
    say = (
        "Wipe plate and face and record these positions again, hands off: an error of seating, label or "
        "disturbance does not repeat."
    )
    return Measurement("again", say, positions(wanted or range(1, 13)))


def channel_moved(where: Mapping[str, Any]) -> Measurement:
    """Return a rest in which the auxiliary channel is changed on purpose, and nothing else."""
    name = where.get("channel", "the auxiliary channel")
    say = f"Leave the cube at rest and change {name} on purpose, to and fro, and nothing else."
    return Measurement("channel_moved", say, {"soak": [{"position": 9, "seconds": SOAK_S / 4}]})


def positions(numbers: Iterable[int], seconds: float = DWELL_S) -> dict[str, list[dict[str, Any]]]:
    """Return dwells in some positions."""
    return {"dwell": [{"position": p, "seconds": seconds} for p in numbers]}


def turned(imu_axes: Sequence[str], about: str) -> tuple[str, ...]:
    """Return where the IMU's x, y, z point (``+x``: along the cube's x) after a turn of 90 deg in the cube."""
    first, second = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}[about]
    onward = {f"+{first}": f"+{second}", f"-{first}": f"-{second}",
              f"+{second}": f"-{first}", f"-{second}": f"+{first}"}  # fmt: skip
    return tuple(onward.get(axis, axis) for axis in imu_axes)


def partner(position: int) -> int:
    """Return the other position on the same face."""
    return next(p for p in range(1, len(POSITIONS) + 1) if p != position and face_of(p) == face_of(position))


def turns(**more: Any) -> list[dict[str, Any]]:
    """Return a turn about every axis, both ways; ``more`` is what each states in addition."""
    return [{"axis": a, "direction": s, "revolutions": REVOLUTIONS, **more} for a in AXES for s in "+-"]


_STATIC = (
    Measurement(
        "free_positions",
        "Lay the cube on its edges and corners, near 45 deg, each time another way round: every rest in an "
        "attitude of its own, which need not be known.",
        {"dwell": [{"attitude": "free", "seconds": DWELL_S}] * FREE},
    ),
    Measurement(
        "heating",
        "Leave the cube at rest and heat the unit by 15 K or more, then let it cool; in both positions: up "
        "and down, so that effects of time, temperature and its rate can be separated.",
        {"soak": [{"position": p, "seconds": SOAK_S} for p in (9, 11)]},
    ),
    Measurement(
        "other_order",
        "Do the twelve positions in this order, on another day, with the room 5 K warmer or colder: effects "
        "of time, of temperature and of the position before can then be separated.",
        positions(MIXED),
    ),
    Measurement(
        "steady_room",
        "Record the same rest again with the air conditioning off, and with the temperature recorded at the "
        "unit: a cycle of the bias then goes, or follows that temperature.",
        {"soak": [{"position": 9, "seconds": SOAK_S}]},
    ),
    Measurement(
        "other_field",
        "Do the twelve positions again with the IMU shielded from the Earth's magnetic field, or elsewhere, "
        "and enter the field there as magnetic_enu_ut.",
        positions(range(1, 13)),
    ),
    Measurement(
        "two_speeds",
        f"Turn about each axis once more, slowly: about {SLOW_DEG_S:g} deg/s, {360 / SLOW_DEG_S:.0f} s a "
        "revolution. A rate table is better, and only fast rates separate a Sagnac sine from a cubic.",
        {"turn": turns(speed_deg_s=SLOW_DEG_S)},
    ),
    Measurement(
        "other_speeds",
        f"Turn about each axis once more, by + at about {OTHER_SPEEDS_DEG_S['+']:g} deg/s and by - at about "
        f"{OTHER_SPEEDS_DEG_S['-']:g} deg/s: at the speeds that there are a cubic, another power and the end "
        "of a range are one. A rate table is better.",
        {"turn": [{**turn, "speed_deg_s": OTHER_SPEEDS_DEG_S[turn["direction"]]} for turn in turns()]},
    ),
    Measurement(
        "after_flips",
        "Begin each of these long dwells right after the flip; the second of a pair follows a turn on the "
        "same face, without a flip: what relaxes after a flip shows in the first only.",
        positions((1, 2, 5, 6, 9, 10), LONG_S),
    ),
    Measurement(
        "reference_time",
        "Record an hour at rest with reference time recorded with the counts (column utc_s), as from a GNSS "
        "receiver.",
        {"soak": [{"position": 9, "seconds": SOAK_S}]},
    ),
    Measurement(
        "certificate",
        "Have the cube's six faces measured and enter them as [[fixture.face]] of campaign.toml, or with "
        "`station fixtures add certificate`; then diagnose the same campaign again. No step on the surface "
        "plate determines it.",
    ),
    Measurement(
        "survey",
        "Have the site surveyed: gravity (gravity_m_s2 with gravity_std_m_s2) or the plate's North mark, as "
        "the finding states; then diagnose the same campaign again.",
    ),
    Measurement(
        "more_revolutions",
        "Do the six turns again with three times the revolutions: a closure error stays, an error of the "
        "scale factor grows with the angle.",
        {"turn": [{**turn, "revolutions": 3 * REVOLUTIONS} for turn in turns()]},
    ),
    Measurement(
        "twice",
        "Do the twelve positions twice over, each time lifted, wiped and set against the stop: what changes "
        "between placements is the seating.",
        positions([*range(1, 13), *range(1, 13)]),
    ),
    Measurement(
        "repeat",
        "Do the campaign again, in another order, on another day: an error that does not repeat is no error term.",
        {**positions(MIXED), "turn": turns()},
    ),
    Measurement(
        "warming_campaign",
        "Do the twelve positions and the turns again while the unit is heated by 15 K, evenly from the first "
        "step to the last.",
        {**positions(MIXED), "turn": turns()},
    ),
    Measurement(
        "longer",
        "Record the unit at rest several times as long, at one temperature: a random walk grows, a drift goes on.",
        {"soak": [{"position": 9, "seconds": 4 * SOAK_S}]},
    ),
)
STATIC: Mapping[str, Measurement] = {one.name: one for one in _STATIC}
"""Those that are the same whatever was found."""


def measurement_name(effect: str) -> MeasurementName:
    """Return what separates an error term, by its record; a name that the catalogue lacks is to repeat."""
    one = CATALOGUE.get(effect)
    if one is None:
        return "repeat"
    if one.next_measurement:
        return one.next_measurement
    match one.driver:
        case "input":
            return "free_positions" if one.triad == "accelerometer" else "other_speeds"
        case "specific force" | "magnetic field":
            return "other_field"
        case "temperature":
            return "warming_campaign" if one.multiplies_output else "heating"
        case "time":
            return "other_order"
        case "time at rest":
            return "after_flips"
        case "channel":
            return "channel_moved"
    return "repeat"


def _measurements(
    effect: str, where: Mapping[str, Any], imu_axes: Sequence[str], is_certified: bool
) -> list[Measurement]:
    name = measurement_name(effect)
    match "remounted" if name == "certificate" and is_certified else name:
        case "remounted":
            return [remounted(imu_axes, about) for about in "zx"]
        case "again":
            return [again(where)]
        case "channel_moved":
            return [channel_moved(where)]
    return [STATIC[name]]


def next_measurements(
    findings: Sequence[Mapping[str, Any]], imu_axes: Sequence[str], is_certified: bool = False
) -> list[Measurement]:
    """Return what would separate each possible finding, or confirm those not of the bench, each once.

    A finding's own measurement comes first; where it has no steps, that of one of its aliases which has.
    ``imu_axes`` is how the IMU was mounted in the cube; if that ``is_certified``, no certificate is asked for.
    """
    doubtful = [finding for finding in findings if finding["confidence"] == "possible"]
    found = dict[str, Measurement]()
    for finding in doubtful or [finding for finding in findings if finding["kind"] != "bench"]:
        names, where = [finding["effect"], *finding.get("aliases", [])], finding.get("where", {})
        ways = [_measurements(name, where, imu_axes, is_certified) for name in names]
        best = next((each for each in ways if each[0].steps), ways[0])
        found |= {one.name: one for one in best if one.name not in found}
    return list(found.values()) or [STATIC["repeat"]]


def write_plans(path: Path, wanted: Sequence[Measurement]) -> dict[Path, list[str]]:
    """Write measurements as `plan/1`, the first to ``path``, others next to it; return the texts of each file.

    What has no steps is a text of the first.

    Raises
    ------
    CannotWrite
        If a file cannot be written.
    """
    with_steps = [one for one in wanted if one.steps] or list(wanted[:1])
    files = [path, *(path.with_name(f"{path.stem}_{i}{path.suffix}") for i in range(2, len(with_steps) + 1))]
    texts = {file: [one.say] for file, one in zip(files, with_steps, strict=True)}
    texts[path] += [f"Also: {one.say}" for one in wanted if one not in with_steps]
    for file, one in zip(files, with_steps, strict=True):
        remarks = "".join(f"# {line}\n" for text in texts[file] for line in wrap(text, WIDTH))
        replace_file(file, (remarks + toml_text(_tables(one))).encode())
    return texts


def _tables(one: Measurement) -> dict[str, Any]:
    fixture = {"fixture": {"imu_axes": list(one.imu_axes)}} if one.imu_axes else {}
    return {"format": FORMAT, **fixture, **{kind: list(steps) for kind, steps in one.steps.items()}}
