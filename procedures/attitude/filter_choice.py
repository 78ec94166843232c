"""Attitude filters that a live unit can be read by, and how each takes the velocity (numbers: You and Lee)."""

from collections.abc import Sequence

JOINT = "joint"
# by filter and by aid: the aid of `procedures.attitude.complementary_filter`
FORMS = {
    "mixer": {"none": "none", "gnss": "airspeed", "airspeed-filter": "airspeed"},
    "paper": {"none": "paper-airspeed", "gnss": "paper-airspeed", "airspeed-filter": "paper-airspeed"},
    "paper-filter": {"gnss": "paper-filter", "airspeed-filter": "paper-filter"},
    "paper-whole": {"gnss": "paper-gnss", "airspeed-filter": "paper-airspeed-rate"},
}
LIVE_FILTERS = (JOINT, *FORMS)
MAX_LIVE_FILTERS = 2  # that stand side by side
FORM_DESCRIPTIONS = {
    "none": "no velocity", "airspeed": "forward speed, angle of attack", "paper-airspeed": "forward speed (10)",
    "paper-filter": "velocity filter (11)-(14)", "paper-airspeed-rate": "speed and its change (9)",
    "paper-gnss": "velocity and its change (9)",
}  # fmt: skip


def parse_filters(text: str) -> tuple[str, ...]:
    """Read one filter, or two with a comma between; raise ValueError where they are none."""
    filters = tuple(part.strip() for part in text.split(",")) if text else (JOINT,)
    if unknown := [name for name in filters if name not in LIVE_FILTERS]:
        names = f"{', '.join(LIVE_FILTERS)}, or two of them"
        raise ValueError(f"found {unknown[0]!r}, expected one of {names}")
    if len(set(filters)) < len(filters) or len(filters) > MAX_LIVE_FILTERS:
        raise ValueError(f"found {text!r}, expected one law, or two different ones: joint,paper")
    return filters


def refuse_without_velocity(filters: Sequence[str], aid: str) -> None:
    """Raise ValueError for a filter that cannot work by an aid."""
    for name in filters:
        if name != JOINT and aid not in FORMS[name]:
            raise ValueError(
                f"law {name} needs a velocity, found aid {aid}, expected gnss or airspeed: give --gnss URL, or "
                f"use the law paper or mixer"
            )
