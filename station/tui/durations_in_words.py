"""Durations and limits as a person reads them."""


def duration_in_words(seconds: float) -> str:
    """Return a time [s] in words: ``45 s``, ``12 min``, ``1 h 05 min``."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02} min"


def beside_limit(value: float, limit: float, unit: str) -> str:
    """Return a value beside its limit: ``0.3 < 3 deg``."""
    form = ".1f" if abs(value) < 100 else ".0f"
    return f"{value:{form}} {'>' if abs(value) > limit else '<'} {limit:g} {unit}".rstrip()
