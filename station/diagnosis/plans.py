"""The measurement that would tell an effect from what it is mistaken for, by effect; a line in the table each.

Steps complement the campaign that was diagnosed: both are then diagnosed together,
``station diagnose FIRST SECOND``. What cannot be written as steps is said in words.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import wrap
from typing import Any

from procedures.frames import AXES, POSITIONS, face_of
from station.campaign_folder.atomic import replace_file
from station.campaign_folder.plan_toml import FORMAT
from station.campaign_folder.schema import CampaignTable
from station.campaign_folder.writing import toml_text

DWELL_S = 100.0
SOAK_S = 3600.0
SLOW_DEG_S, REVOLUTIONS = 12.0, 3  # a hand turns at about 35 deg/s unless told
LONG_S = 600.0
FREE = 12
WIDTH = 100
MIXED = (1, 9, 6, 12, 4, 7, 2, 10, 5, 11, 3, 8)  # every flip between other faces than in 1..12

Tables = Mapping[str, Sequence[Mapping[str, Any]]]


@dataclass(frozen=True, slots=True)
class NextPlan:
    """What to measure next: ``say`` in words, and steps by kind, as `plan/1` has them; ``imu_axes`` if re-mounted."""

    name: str
    say: str
    steps: Tables = field(default_factory=dict)
    imu_axes: tuple[str, ...] = ()


def free_positions(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """Rests near 45 deg, at which products of inputs and powers above the second show."""
    say = (
        "Lay the cube on its edges and corners, near 45 deg, each time another way round: each rest in an attitude "
        "of its own, which need not be known."
    )
    return NextPlan("free_positions", say, {"dwell": [{"attitude": "free", "seconds": DWELL_S}] * FREE})


def remounted_about_z(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The twelve positions with the IMU turned by 90 deg about the cube's z: what is the cube's changes channel."""
    return _remounted("z", campaign)


def remounted_about_x(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The same about x: one mounting leaves open what lies along its own axis, two leave nothing."""
    return _remounted("x", campaign)


def certificate(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """A certificate of the faces; the cube is measured elsewhere."""
    say = (
        "Have the cube's six faces measured and enter them as [[fixture.face]] of campaign.toml, or with "
        "`station fixtures add certificate`; then diagnose the same campaign again. No step on the slab tells it."
    )
    return NextPlan("certificate", say)


def heating(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """A run up and down in temperature at rest: it comes back to every temperature at another rate and time."""
    say = (
        "Leave the cube at rest and heat the unit by 15 K or more, then let it cool: up and down, so that time, "
        "temperature and its rate part."
    )
    return NextPlan("heating", say, {"soak": [{"position": p, "seconds": SOAK_S} for p in (9, 11)]})


def other_order(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The same positions in another order and at another temperature: time and temperature part."""
    say = (
        "Do the twelve positions in this order, on another day or with the room 5 K warmer or colder: what follows "
        "time, what follows temperature and what follows the position before then part."
    )
    return NextPlan("other_order", say, _positions(MIXED))


def other_field(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The same positions in another magnetic field: g-sensitivity stays, the magnetic effect moves."""
    say = (
        "Do the twelve positions again with the IMU shielded from the Earth's magnetic field, or elsewhere, and "
        "enter the field there as magnetic_enu_ut."
    )
    return NextPlan("other_field", say, _positions(range(1, 13)))


def two_speeds(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The six turns at another speed: an asymmetry does not depend on speed, a nonlinearity does."""
    turns = [
        {"axis": axis, "direction": sense, "revolutions": REVOLUTIONS, "speed_deg_s": SLOW_DEG_S}
        for axis in AXES
        for sense in "+-"
    ]
    say = (
        f"Turn about each axis once more, slowly: about {SLOW_DEG_S:g} deg/s, {360 / SLOW_DEG_S:.0f} s a revolution. "
        f"A rate table tells more."
    )
    return NextPlan("two_speeds", say, {"turn": turns})


def again(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The position that stood out, its pair partner, and one of another face, once more."""
    named = finding.get("where", {}).get("position", [])
    found = [p for p in (named if isinstance(named, list) else [named]) if p in range(1, len(POSITIONS) + 1)]
    wanted = dict.fromkeys(q for p in found for q in (p, partner(p)))
    say = (
        "Wipe slab and face and do these positions again, hands off: what was a seating, a label or a disturbance "
        "does not come back."
    )
    return NextPlan("again", say, _positions(wanted or range(1, 13)))


def after_flips(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """Long dwells, each right after a flip and then again after a turn on the same face."""
    say = (
        "Begin each of these long dwells right after the flip; the second of a pair follows a turn on the same face, "
        "without a flip: what relaxes after a flip shows in the first only."
    )
    return NextPlan("after_flips", say, _positions((1, 2, 5, 6, 9, 10), LONG_S))


def survey(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """A survey of the site."""
    say = (
        "Have the site surveyed: gravity (gravity_m_s2 with gravity_std_m_s2) or the slab's North mark, as the "
        "finding says; then diagnose the same campaign again."
    )
    return NextPlan("survey", say)


def reference_time(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """A recording beside a reference clock."""
    say = "Record an hour at rest with reference time beside the counts (column utc_s), as from a GNSS receiver."
    return NextPlan("reference_time", say, {"soak": [{"position": 9, "seconds": SOAK_S}]})


def channel_moved(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """A soak in which the auxiliary channel is changed on purpose, and nothing else."""
    name = finding.get("where", {}).get("channel", "the auxiliary channel")
    say = f"Leave the cube at rest and change {name} on purpose, to and fro, with nothing else changing."
    return NextPlan("channel_moved", say, {"soak": [{"position": 9, "seconds": SOAK_S / 4}]})


Measurement = Callable[[Mapping[str, Any], CampaignTable], NextPlan]
BY_MOUNTING = (remounted_about_z, remounted_about_x)
MEASUREMENTS: Mapping[str, tuple[Measurement, ...]] = {
    "accelerometer.quadratic": BY_MOUNTING,
    "accelerometer.cubic": (free_positions,),
    "accelerometer.scale_asymmetry": (free_positions,),
    "accelerometer.cross_product": (free_positions,),
    "accelerometer.bias_temperature": (other_order,),
    "accelerometer.scale_temperature": (other_order,),
    "accelerometer.bias_drift": (other_order,),
    "accelerometer.relaxation": (after_flips,),
    "gyroscope.g_sensitivity": (other_field,),
    "gyroscope.bias_temperature": (other_order,),
    "gyroscope.scale_temperature": (heating,),
    "gyroscope.temperature_rate": (heating,),
    "gyroscope.bias_drift": (other_order,),
    "gyroscope.magnetic": (other_field,),
    "gyroscope.scale_asymmetry": (two_speeds,),
    "gyroscope.scale_nonlinearity": (two_speeds,),
    "gyroscope.sagnac_sine": (two_speeds,),
    "slab.tilt": (again,),
    "fixture.face_tilt": (certificate,),
    "fixture.parallelism": BY_MOUNTING,
    "placement.dwell": (again,),
    "placement.label": (again,),
    "site.azimuth": (survey,),
    "site.gravity": (survey,),
    "clock.rate": (reference_time,),
    "disturbance.dwell": (again,),
    "auxiliary.channel": (channel_moved,),
}


def next_plans(findings: Sequence[Mapping[str, Any]], campaign: CampaignTable) -> list[NextPlan]:
    """Return what would separate each ambiguous finding, of all findings if none is, each measurement once.

    The finding's own measurement goes first; where it has no steps, that of one of its aliases which has.
    """
    doubtful = [f for f in findings if f["confidence"] == "ambiguous"] or list(findings)
    found = dict[str, NextPlan]()
    for finding in doubtful:
        names = [finding["effect"], *finding.get("aliases", [])]
        plans = [[make(finding, campaign) for make in MEASUREMENTS.get(name, (repeat,))] for name in names]
        best = next((each for each in plans if each[0].steps), plans[0])
        found |= {plan.name: plan for plan in best if plan.name not in found}
    return list(found.values()) or [repeat({}, campaign)]


def repeat(finding: Mapping[str, Any], campaign: CampaignTable) -> NextPlan:
    """The usual campaign once more: what does not repeat is no structure."""
    turns = [{"axis": axis, "direction": sense, "revolutions": REVOLUTIONS} for axis in AXES for sense in "+-"]
    say = "Do the campaign again, in another order, on another day: what does not come back is no effect."
    return NextPlan("repeat", say, {**_positions(MIXED), "turn": turns})


def turned(imu_axes: Sequence[str], about: str) -> tuple[str, ...]:
    """Return where the IMU's x, y, z point (``+x``: along the cube's x) once it is turned by 90 deg in the cube."""
    first, second = {"x": "yz", "y": "zx", "z": "xy"}[about]
    onward = {"+" + first: "+" + second, "-" + first: "-" + second,
              "+" + second: "-" + first, "-" + second: "+" + first}  # fmt: skip
    return tuple(onward.get(axis, axis) for axis in imu_axes)


def _remounted(about: str, campaign: CampaignTable) -> NextPlan:
    axes = turned(campaign.fixture.imu_axes, about)
    say = (
        f"Mount the IMU turned by 90 deg about the cube's {about}, so that its x, y, z point along the cube's "
        f"{', '.join(axes)}, and do the twelve positions: what is the cube's then shows in another channel. It takes "
        f"two such mountings, about two axes. A certificate of the faces or free positions near 45 deg tell it too."
    )
    return NextPlan(f"remounted_about_{about}", say, _positions(range(1, 13)), axes)


def partner(position: int) -> int:
    """Return the other position on the same face."""
    return next(p for p in range(1, len(POSITIONS) + 1) if p != position and face_of(p) == face_of(position))


def write_next_plans(path: Path, plans: Sequence[NextPlan]) -> list[Path]:
    """Write ``plans`` as `plan/1`, the first to ``path``, others beside it; return the files.

    What has no steps is a remark in the first.

    Raises
    ------
    CannotWrite
        If a file cannot be written.
    """
    with_steps = [plan for plan in plans if plan.steps] or list(plans[:1])
    besides = [f"Besides: {plan.say}" for plan in plans if plan not in with_steps]
    files = [path, *(path.with_name(f"{path.stem}_{i}{path.suffix}") for i in range(2, len(with_steps) + 1))]
    for file, plan in zip(files, with_steps, strict=True):
        said = [plan.say, *(besides if file == path else [])]
        remarks = "".join(f"# {line}\n" for text in said for line in wrap(text, WIDTH))
        tables: dict[str, Any] = {"format": FORMAT}
        if plan.imu_axes:
            tables["fixture"] = {"imu_axes": list(plan.imu_axes)}
        tables |= {kind: list(steps) for kind, steps in plan.steps.items()}
        replace_file(file, (remarks + toml_text(tables)).encode())
    return files


def _positions(numbers: Iterable[int], seconds: float = DWELL_S) -> Tables:
    return {"dwell": [{"position": p, "seconds": seconds} for p in numbers]}
