"""Names and free text in files that are handed in: what may stand on screens, on pages and in names of files.

A name becomes part of names of files and pages: it is short, printable, and no path. Free text may have letters of
any script, but nothing that moves the cursor or turns the direction of writing (Unicode categories `_UNSEEN`).
"""

import re
import unicodedata
from typing import Annotated

from pydantic import AfterValidator, StringConstraints

LONGEST_NAME, LONGEST_TEXT = 64, 1000  # characters: a line of a certificate's table, and a paragraph
_UNSEEN = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}


def unseen(text: str) -> str:
    """Return the code points of characters that are not seen, such as U+202E; empty where there are none."""
    return ", ".join(sorted({f"U+{ord(c):04X}" for c in text if unicodedata.category(c) in _UNSEEN}))


def checked_text(text: str) -> str:
    """Return free text as it is; raise ValueError if it is too long or has characters that are not seen."""
    if len(text) > LONGEST_TEXT:
        raise ValueError(f"at most {LONGEST_TEXT} characters, not {len(text)}")
    if found := unseen(text):
        raise ValueError(f"printable characters, not {found[:60]}")
    return text


def checked_name(name: str) -> str:
    """Return a name as it is; raise ValueError if it is empty, too long, a path, or not printable."""
    checked_text(name)
    if not name.strip() or name != name.strip() or len(name) > LONGEST_NAME:
        raise ValueError(f"a name of 1 to {LONGEST_NAME} characters without spaces at its ends")
    if set(name) & {"/", "\\"} or name.startswith("."):
        raise ValueError("a name that is no path: without / and \\, not beginning with a dot")
    return name


def matching(pattern: str, words: str) -> AfterValidator:
    """Return what takes text that matches ``pattern`` as a whole; a refusal expects it in ``words``."""

    def checked(text: str) -> str:
        if not re.fullmatch(pattern, text, re.ASCII):
            raise ValueError(words)
        return text

    return AfterValidator(checked)


Sha256 = Annotated[str, matching("[0-9a-f]{64}", "64 digits 0 to 9 and a to f, a SHA-256")]
Name = Annotated[str, AfterValidator(checked_name)]
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1), AfterValidator(checked_text)]
