"""What a look at many ports found, in lines for a terminal."""

from collections.abc import Sequence
from textwrap import wrap

from station.devices.port_survey import SurveyedPort

INDENT_CHARS = 4


def survey_lines(found: Sequence[SurveyedPort]) -> list[str]:
    """Return two lines or more for each port: its address, then what comes out of it."""
    return [line for each in found for line in _lines(each)]


def fitted(lines: Sequence[str], width: int, height: int) -> list[str]:
    """Return lines broken between words to a terminal's width; what is too much for its height is counted."""
    broken = [
        part
        for line in lines
        for part in wrap(line, width, subsequent_indent=" " * 2 * INDENT_CHARS, break_on_hyphens=False)
    ]
    if len(broken) <= height:
        return broken
    return [*broken[: height - 1], f"... {len(broken) - height + 1} more lines: --url URL looks at one alone"]


def _lines(found: SurveyedPort) -> list[str]:
    lines = [f"{found.url}  {found.about}".rstrip()]
    if not found.looks_like or found.trouble:
        return [*lines, f"{'':{INDENT_CHARS}}{found.trouble}"]
    named = [found.looks_like, found.model or "", f"serial number {found.serial}" if found.serial else ""]
    rates = [f"{found.frames_s:.1f} frames/s", f"{found.bytes_s:.0f} bytes/s"]
    if found.rate_hz is not None:
        rates.append(f"{found.rate_hz:.6g} Hz by its own time")
    bad = [f"{count} {name.replace('_', ' ')}" for name, count in found.errors.items() if count]
    said = [", ".join(part for part in [*named, *rates] if part)]
    said += [f"system {system}: {rate:.1f} frames/s" for system, rate in found.systems.items()]
    if found.position:
        said.append(f"receiver: {found.position}")
    if found.messages:
        said.append(", ".join(f"{name} {rate:.1f} Hz" for name, rate in found.messages.items()))
    return [*lines, *(f"{'':{INDENT_CHARS}}{text}" for text in [*said, f"errors: {', '.join(bad) or 'none'}"])]
