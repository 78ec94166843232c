"""The attitude laws that a live unit can be read by, and how each takes the velocity that there is.

Equation numbers are those of You and Lee.
"""

from collections.abc import Sequence

JOINT = "joint"
# by law and by aid: the aid of `procedures.attitude.complementary_filter`
FORMS = {
    "mixer": {"none": "none", "gnss": "airspeed", "airspeed-filter": "airspeed"},
    "paper": {"none": "paper-airspeed", "gnss": "paper-airspeed", "airspeed-filter": "paper-airspeed"},
    "paper-filter": {"gnss": "paper-filter", "airspeed-filter": "paper-filter"},
    "paper-whole": {"gnss": "paper-gnss", "airspeed-filter": "paper-airspeed-rate"},
}
LAWS = (JOINT, *FORMS)
MAX_LAWS = 2  # that stand side by side
FORM_IN_WORDS = {
    "none": "no velocity", "airspeed": "forward speed, angle of attack", "paper-airspeed": "forward speed (10)",
    "paper-filter": "velocity filter (11)-(14)", "paper-airspeed-rate": "speed and its change (9)",
    "paper-gnss": "velocity and its change (9)",
}  # fmt: skip


def parse_laws(text: str) -> tuple[str, ...]:
    """Read one law, or two with a comma between; raise ValueError where they are none."""
    laws = tuple(part.strip() for part in text.split(",")) if text else (JOINT,)
    if unknown := [law for law in laws if law not in LAWS]:
        names = f"{', '.join(LAWS)}, or two of them"
        raise ValueError(f"found {unknown[0]!r}, expected one of {names}")
    if len(set(laws)) < len(laws) or len(laws) > MAX_LAWS:
        raise ValueError(f"found {text!r}, expected one law, or two different ones: joint,paper")
    return laws


def refuse_without_velocity(laws: Sequence[str], aid: str) -> None:
    """Raise ValueError for a law that cannot work by an aid."""
    for law in laws:
        if law != JOINT and aid not in FORMS[law]:
            raise ValueError(
                f"law {law} needs a velocity, found aid {aid}, expected gnss or airspeed: give --gnss URL, or "
                f"use the law paper or mixer"
            )
