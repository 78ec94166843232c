"""docs/how-to/streaming.md says what the code does: layout, flags, and readers in Python and C that read."""

import os
import re
import select
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from station.sending.outputs import Quality, open_outputs
from station.sending.to_udp import DATAGRAM, MAGIC
from tests.free_port import free_udp_port
from tests.paths import ROOT
from tests.station.sending.test_outputs import ABOUT, made

PAGE = (ROOT / "docs/how-to/streaming.md").read_text(encoding="utf-8")
TYPES = {"4 bytes": "S4", "u32": "<u4", "u64": "<u8", "f64": "<f8", "3 f64": ("<f8", (3,))}
COMPILER = ("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-D_DEFAULT_SOURCE")


def test_the_layout_is_the_one_that_is_sent() -> None:
    rows = re.findall(r"^\| (\d+) \| (\d+) \| `(\w+)` \| ([^|]+) \|", PAGE, re.MULTILINE)
    assert [name for _, _, name, _ in rows] == list(DATAGRAM.names or ())
    for offset, size, name, kind in rows:
        field, at = (DATAGRAM.fields or {})[name][:2]
        assert (int(offset), int(size)) == (at, field.itemsize)
        assert field == np.dtype(TYPES[kind])
    assert f"{DATAGRAM.itemsize} bytes, no padding" in PAGE
    assert MAGIC.decode() in PAGE


def test_every_flag_is_reported() -> None:
    rows = re.findall(r"^\| (\d+) \| `(\w+)` \|", PAGE, re.MULTILINE)
    received = {name: 1 << int(bit) for bit, name in rows if name in {str(flag.name).lower() for flag in Quality}}
    assert received == {str(flag.name).lower(): int(flag) for flag in Quality}


@pytest.mark.parametrize("language", ["py", "c"])
def test_the_reader_reads(language: str, tmp_path: Path) -> None:
    source = ROOT / f"docs/examples/udp_reader.{language}"
    command = [sys.executable, str(source)]
    if language == "c":
        if shutil.which("cc") is None:
            pytest.skip("no C compiler")
        command = [str(tmp_path / "reader")]
        subprocess.run([*COMPILER, str(source), "-o", command[0]], check=True)
    port = free_udp_port()
    reader = subprocess.Popen([*command, str(port)], stdout=subprocess.PIPE, bufsize=0)
    assert reader.stdout is not None
    os.set_blocking(reader.stdout.fileno(), False)
    (output,) = open_outputs([f"udp:127.0.0.1:{port}"], ABOUT)
    samples, reported = made(3), b""
    try:
        while not (lines := _from_the_first_on(reported)):  # it may begin to listen between two of the three
            output.send(samples)
            select.select([reader.stdout], [], [], 0.2)
            reported += reader.stdout.read() or b""
    finally:
        reader.kill()
        reader.wait()
        reader.stdout.close()
        output.close()
    for i, line in enumerate(lines):
        sequence, t, *six, flags = line.split()
        assert (int(sequence), float(t), int(flags, 0)) == (i, samples.t[i], samples.flags[i])
        assert [float(value) for value in six] == [*samples.f[i].tolist(), *samples.omega[i].tolist()]


def _from_the_first_on(reported: bytes) -> list[str]:
    """Return three whole lines from that of the first sample on, none where they have not all come."""
    lines = reported.decode().split("\n")[:-1]
    first = next((i for i, line in enumerate(lines) if line.startswith("0 ")), len(lines))
    return lines[first : first + 3] if len(lines) >= first + 3 else []
