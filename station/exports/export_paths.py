"""Where an export goes: to a file, to files that share a name, or into a folder under the usual name."""

import re
from pathlib import Path

from station.errors import CannotWrite
from station.exports import PREFIX, Export

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}", re.ASCII)
C_WORDS = frozenset(
    (
        "auto break case char const continue default do double else enum extern float for goto if inline int long "
        "main register restrict return short signed sizeof static struct switch typedef union unsigned void "
        "volatile while"
    ).split()
)


def export_paths(export: Export, out: Path) -> tuple[str, dict[str, Path]]:
    """Return the name of an export, and the path of each of its files by the end of its name.

    ``out`` is a folder, made if it is not there, or a file whose name without its end is taken.

    Raises
    ------
    CannotWrite
        If several files would be one, or a program would have a name that C does not take.
    """
    if len(export.ends) == 1 and not out.is_dir():
        return PREFIX, {export.ends[0]: out}
    is_file = out.suffix in export.ends and not out.is_dir()
    if not is_file and out.suffix and not out.is_dir():
        raise CannotWrite(out, f"{export.name} writes {' and '.join(f'NAME{end}' for end in export.ends)}")
    name, folder = (out.stem, out.parent) if is_file else (PREFIX, out)
    if not _IDENTIFIER.fullmatch(name) or name in C_WORDS:
        raise CannotWrite(out, f"{name} is no name for a program: letters, digits and _, up to 31")
    return name, {end: folder / f"{name}{end}" for end in export.ends}
