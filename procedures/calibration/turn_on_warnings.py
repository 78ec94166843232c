"""What a solution says of a unit that was switched off and on within a campaign."""

from collections.abc import Sequence

from procedures.campaign.campaign import Campaign
from procedures.dwells_and_turns.gyroscopes_joint_fit import GyroscopeFit
from procedures.dwells_and_turns.twelve_position import TriadFit
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G


def turn_on_warnings(
    campaigns: Sequence[Campaign], accelerometer: TriadFit | None, gyroscope: GyroscopeFit | None
) -> list[str]:
    """Say which bias the solution has, and by how much turn-ons differed; nothing of campaigns with one."""
    times = max(_turn_ons(each) for each in campaigns)
    if times < 2:
        return []
    triads = (
        ("accelerometer", accelerometer, "ug", UG_PER_G),
        ("gyroscope", None if gyroscope is None else gyroscope.joint, "deg/h", DEG_H_PER_DEG_S),
    )
    parts = list[str]()
    for name, joint, unit, per in triads:
        if joint is not None and joint.profiled:
            spread = joint.spread / joint.k * per
            parts.append(f"{name} {', '.join(f'{each:.2g}' for each in spread)} {unit}")
        elif joint is not None:
            parts.append(f"{name} not separated: one bias was solved for all")
    return [
        f"the unit was switched on {times} times within a campaign: each power-on has its own biases, and the "
        f"bias here is their mean; u of the mean x, y, z: {'; '.join(parts)}, included in its uncertainty"
    ]


def _turn_ons(campaign: Campaign) -> int:
    return len({dwell.turn_on for dwell in campaign.dwells} | {turn.turn_on for turn in campaign.turns})
