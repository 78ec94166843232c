"""A count and what is counted, as they are said: 1 gap, 2 gaps."""


def plural(count: int, noun: str) -> str:
    """Return ``count`` and the noun, in the plural unless it is one."""
    ending = "" if count == 1 else "es" if noun.endswith("x") else "s"
    return f"{count} {noun}{ending}"
