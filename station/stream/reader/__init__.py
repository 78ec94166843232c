"""Reading a device is its own process: it reads, stamps, journals and streams, nothing else.

`reader` starts the process and receives its `messages`. `__main__` is the process: it reads the
device, opens it again after it was unplugged, and `journal` writes every byte to the disk.
"""

from station.stream.reader.messages import Chunk, StreamGap
from station.stream.reader.reader import Reader

__all__ = ["Chunk", "Reader", "StreamGap"]
