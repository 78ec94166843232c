"""Turns of what is not solved, as `diagnosis/2` and as lines."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from procedures.campaign.campaign import Campaign
from procedures.diagnosis.rotation_summary import TurnSeen, left_open, pooled, turns_seen
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S
from station.results.solution_text import measured


def turns(campaigns: Sequence[Campaign]) -> dict[str, Any]:
    """Return ``turns``, what they do not show (``turns_leave_open``), and the mean of several (``turns_mean``)."""
    seen = turns_seen(campaigns)
    if not seen:
        return {}
    nominal = campaigns[0].nominal_scale.get("gyroscope")
    mean = [
        {"channel": f"gyroscope {AXES[sensor]}", "scale_factor": _value(*scale, _unit(seen[0]))}
        for sensor, scale in pooled(seen).items()
    ]
    found: dict[str, Any] = {
        "turns": [_document(each, nominal) for each in seen],
        "turns_leave_open": left_open(seen),
    }
    return found | ({"turns_mean": mean} if mean else {})


def _unit(seen: TurnSeen) -> str:
    return "count/deg" if seen.is_count else "output/(deg/s)"


def _value(value: float, std: float, unit: str) -> dict[str, Any]:
    return {"value": value, "std": std, "unit": unit}


def _document(seen: TurnSeen, nominal: float | None) -> dict[str, Any]:
    told: dict[str, Any] = {
        "recording": seen.name, "axis": seen.axis, "channel": f"gyroscope {AXES[seen.sensor]}",
        "revolutions": seen.revolutions, "angle_deg": 360.0 * seen.revolutions, "seconds": seen.seconds,
    }  # fmt: skip
    is_whole = seen.revolutions % 1 == 0
    if is_whole:
        told["revolutions"] = int(seen.revolutions)
    if seen.scale is not None:
        told["scale_factor"] = _value(*seen.scale, _unit(seen))
    if seen.at_rest is not None:
        per = DEG_H_PER_DEG_S / nominal if nominal else 1.0
        unit = "deg/h" if nominal else "count/s" if seen.is_count else "output"
        told["at_rest"] = _value(seen.at_rest[0] * per, seen.at_rest[1] * abs(per), unit)
    if seen.turned_deg is not None:
        told["turned"] = _value(*seen.turned_deg, "deg")
        if seen.is_as_told:
            told["beyond_whole_turns" if is_whole else "beyond_angle_told"] = _value(
                seen.turned_deg[0] - 360.0 * seen.revolutions, seen.turned_deg[1], "deg"
            )
    return told


def turns_lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield what `turns` found, as text in 80 columns; +- is 1 sigma."""
    for each in document.get("turns", []):
        yield f"{each['channel']}, {each['axis']} in {each['recording']}, {each['seconds']:.0f} s"
        for key, name in (
            ("scale_factor", "scale factor"), ("turned", "turned"), ("beyond_whole_turns", "beyond whole turns"),
            ("beyond_angle_told", "beyond stated angle"), ("at_rest", "at rest"),
        ):  # fmt: skip
            if key in each:
                yield f"   {name:<20}{measured(each[key]['value'], each[key]['std'])} {each[key]['unit']}"
    for each in document.get("turns_mean", []):
        scale = each["scale_factor"]
        yield f"{each['channel']}, all turns: {measured(scale['value'], scale['std'])} {scale['unit']}"
    if "turns" in document:
        rested = any("at_rest" in each for each in document["turns"])
        yield (
            "at rest is the bias with the Earth's rate along the axis; " if rested else ""
        ) + "not determined by this:"
        yield from (f"   {said}" for said in document["turns_leave_open"])
