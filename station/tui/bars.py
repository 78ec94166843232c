"""Horizontal bars of block characters."""

from textual.content import Content

_EIGHTHS = " ▏▎▍▌▋▊▉"


def bar(fraction: float, width: int, colour: str) -> Content:
    """Return a bar ``width`` characters long; ``fraction`` beyond 0..1 is cut."""
    eighths = round(min(max(fraction, 0.0), 1.0) * width * 8)
    full, part = divmod(eighths, 8)
    filled = "█" * full + (_EIGHTHS[part] if part else "")
    return Content.assemble((filled, colour), (" " * (width - len(filled)), "on $foreground 12%"))


def pointer(fraction: float, width: int) -> str:
    """Return a scale of ``width`` characters with a mark at ``fraction`` of it."""
    at = round(min(max(fraction, 0.0), 1.0) * (width - 1))
    return "─" * at + "◆" + "─" * (width - 1 - at)
