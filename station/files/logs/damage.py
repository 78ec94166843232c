"""What libraries raise where an archive or a table of columns is damaged."""

import lzma
import struct
import zipfile
import zlib

DAMAGE: tuple[type[Exception], ...] = (
    ValueError, TypeError, KeyError, IndexError, AttributeError, EOFError, MemoryError, OverflowError,
    RuntimeError, NotImplementedError, struct.error, zlib.error, lzma.LZMAError, zipfile.BadZipFile,
)  # fmt: skip
DAMAGED_WITHIN: tuple[type[Exception], ...] = (*DAMAGE, OSError)  # once a file has been opened


def in_a_line(error: Exception) -> str:
    """Return what was raised in a few words."""
    lines = str(error).splitlines()
    return lines[0][:160] if lines and lines[0] else "cut short"
