"""What a monitor step reads, in words."""

from station.guide.view import MonitoredView


def laws_in_words(seen: MonitoredView) -> str:
    """Return it for people: ``joint roll 0.003 pitch -0.001, mixer ..., 0.002 deg apart``."""
    if not seen.laws:
        return seen.text
    said = [f"{law.law} roll {law.roll_deg:+.3f} pitch {law.pitch_deg:+.3f}" for law in seen.laws]
    apart = "" if seen.difference_deg is None else f"; {seen.difference_deg:.3f} deg apart"
    return f"{', '.join(said)}{apart}"
