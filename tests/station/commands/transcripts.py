"""Command lines run one after the other in an empty folder; what they say is one text, kept by a snapshot."""

import re
import shlex
from collections.abc import Iterable
from datetime import date, timedelta
from pathlib import Path

import pytest
from syrupy.extensions.single_file import SingleFileSnapshotExtension, WriteMode

from station import cli

File = tuple[str, str]  # name and content, written before the next line runs
Step = str | File

MASKED = (
    (r"serial ports present: [^;]*|no serial port is present", "serial ports present: ..."),
    (r"fog-station \d\S*( \([^)]*\))?", "fog-station VERSION"),
    (r"journal (\d+)-[0-9a-f]{16}", r"journal \1-CODE"),
    (r"\[(E-[A-Z-]+): [^\]]*\]", r"[\1]"),  # its meaning stands in docs/reference/error-codes.md
    (rf"({date.today()}|{date.today() - timedelta(days=1)})([ T]\d\d:\d\d(:\d\d)?)?", "TODAY"),
)


class TextFile(SingleFileSnapshotExtension):
    """A snapshot that anybody can read: one text file for each command."""

    _write_mode = WriteMode.TEXT
    _file_extension = "txt"


def transcript(steps: Iterable[Step], folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Return each command line, what it said with the stable code of its refusal, and its exit code."""
    parts = list[str]()
    for step in steps:
        if isinstance(step, tuple):
            (folder / step[0]).write_bytes(step[1].encode("utf-8", "surrogateescape"))
            continue
        code = cli.run([*shlex.split(step), "--verbose"])
        out, error = capsys.readouterr()
        refusal = [line for line in error.splitlines() if not line.startswith("inferred: ")]
        assert len(refusal) == (code != 0), error
        assert "Traceback" not in error
        reported = (out + error).replace(f"{folder}/", "").replace(str(folder), ".")
        for pattern, shown in MASKED:
            reported = re.sub(pattern, shown, reported)
        parts.append(f"$ station {shown_line(step)}\n{reported.rstrip()}\n(exit code {code})\n")
    return "\n".join(parts)


def shown_line(step: str) -> str:
    """Return a command line as it is shown: one line, however long what it names."""
    return step if len(step) < 200 else f"{step[:200]} ..."
