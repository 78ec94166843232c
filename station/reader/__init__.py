"""Reading a device is a process of its own: it reads, stamps, journals and hands on, nothing else."""

from station.reader.messages import Chunk, GapMark
from station.reader.reader import Reader

__all__ = ["Chunk", "GapMark", "Reader"]
