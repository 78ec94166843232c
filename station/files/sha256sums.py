"""``SHA256SUMS``: the hash of each recorded file of a folder, in the format of sha256sum(1)."""

import hashlib
import os
import re
from pathlib import Path

from station.errors import Altered, DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.opening import MAX_LINE, open_inside, sha256_inside

SHA256SUMS = "SHA256SUMS"
_LINE = re.compile(r"([0-9a-f]{64}) [ *]([^\\\n]+)")


def append_hash(folder: Path, name: str, sha256: str) -> None:
    """Record the hash of an accepted file; it is on the disk when this returns.

    A name that has a line, as ``campaign.toml`` of a growing campaign has, is given the new hash in its place.
    Raise `CannotWrite` if the folder cannot be written.
    """
    line = f"{sha256}  {name}\n"
    if not _LINE.fullmatch(line[:-1]):
        raise ValueError(f"{name!r} with {sha256!r} does not fit a line of {SHA256SUMS}")
    hashes = read_hashes(folder) if (folder / SHA256SUMS).exists() else {}
    others = "".join(f"{sha}  {other}\n" for other, (sha, _) in hashes.items() if other != name)
    replace_file(folder / SHA256SUMS, (others + line).encode())  # whole: a full disk must not leave half a line


def read_hashes(folder: Path) -> dict[str, tuple[str, int]]:
    """Return the recorded hash and its line number by file name; of a file recorded twice the last counts.

    Raise `DataRefused` if there is no readable ``SHA256SUMS``.
    """
    if not (folder / SHA256SUMS).exists():
        raise DataRefused(folder, None, f"no {SHA256SUMS}", "a folder that the station recorded", "name one")
    with open_inside(folder, SHA256SUMS, folder, None) as stream:
        content = stream.read(64 * MAX_LINE)
    hashes = dict[str, tuple[str, int]]()
    for number, line in enumerate(content.decode("utf-8", "backslashreplace").splitlines(), start=1):
        if not (found := _LINE.fullmatch(line)):
            raise DataRefused(
                folder / SHA256SUMS, number, ascii(line[:40]), "a sha256, two blanks and a file name"
            )
        hashes[found[2]] = (found[1], number)
    return hashes


def sha256_of(path: Path) -> str:
    """Return the hash of a file's bytes; raise `DataRefused` if it cannot be read."""
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise DataRefused(path, None, f"no readable file ({error.strerror})", "the file to verify") from error


def verify_folder(folder: Path) -> list[str]:
    """Hash every recorded file of a folder again and return their names.

    Raises
    ------
    Altered
        At the first file that differs, is missing, or is named in ``campaign.toml`` but has no hash.
    DataRefused
        If there are no hashes to compare with.
    """
    hashes = read_hashes(folder)
    for name, (recorded, line) in hashes.items():
        if not os.path.lexists(folder / name):
            raise Altered(folder / name, "no such file", f"sha256 {recorded}")
        found = sha256_inside(folder, name, folder / SHA256SUMS, line)
        if found != recorded:
            raise Altered(folder / name, f"sha256 {found}", recorded)
    if (folder / CAMPAIGN_TOML).exists():
        tables, _, _ = read_campaign_toml(folder)
        for step in tables.steps():
            if step.file not in hashes:
                raise Altered(folder / step.file, "a step without a hash", f"a line in {SHA256SUMS}")
        for name in () if tables.effects is None else tables.effects.files:
            if name not in hashes:
                raise Altered(folder / name, "an effect without a hash", f"a line in {SHA256SUMS}")
    return list(hashes)
