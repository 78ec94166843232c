"""A count and what is counted, as they are said: 1 gap, 2 gaps; a unit by its model and serial number."""

NOT_KNOWN = "unknown"  # what a log that names neither has for model and serial number


def plural(count: int, noun: str) -> str:
    """Return ``count`` and the noun, in the plural unless it is one."""
    ending = "" if count == 1 else "es" if noun.endswith("x") else "s"
    return f"{count} {noun}{ending}"


def unit_in_words(model: str, serial: str) -> str:
    """Return model and serial number, or that neither is known."""
    known = [name for name in (model, serial) if name != NOT_KNOWN]
    return " ".join(known) if known else "unit not named"
