"""Reading a device is its own process: it reads, stamps, records and streams, nothing else.

`reader` starts the process and receives its `messages`. `__main__` is the process: `reconnecting_port` reads the
device and opens it again after it was unplugged, `raw_recording` writes every byte to the disk.
"""

from station.stream.reader.messages import Chunk, StreamGap
from station.stream.reader.reader import Reader

__all__ = ["Chunk", "Reader", "StreamGap"]
