"""Why something failed, in the words of the system and once: libraries wrap its words in their own, and again."""

import os
import re

_NUMBERED = re.compile(r"\[Errno -?\d+\] ([^:\[\]'\"]+)|\(-?\d+, '([^']+)'\)")
_SAID = {  # what libraries say in words of their own
    "returned no data": "it sends nothing any more: unplugged, or another program reads it too",
    "port that is not open": "it is closed",
}


def reason_of(error: BaseException) -> str:
    """Return one short clause: no numbers, no name of what failed, nothing twice."""
    text = " ".join(str(error).split())
    for said, meant in _SAID.items():
        if said in text:
            return meant
    if numbered := _NUMBERED.findall(text):
        return str(next(filter(None, numbered[-1]))).strip()
    code = getattr(error, "errno", None)
    if isinstance(code, int) and code > 0:
        return os.strerror(code)
    return getattr(error, "strerror", None) or text or type(error).__name__
