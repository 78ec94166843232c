"""Reading a device is a process of its own: it reads, stamps, journals and hands on, nothing else."""

from station.stream.reader.messages import Chunk, GapMark
from station.stream.reader.reader import Reader

__all__ = ["Chunk", "GapMark", "Reader"]
