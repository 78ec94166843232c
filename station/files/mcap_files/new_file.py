"""A new MCAP file: chunked, compressed, with checksums; one that is there is never overwritten."""

from pathlib import Path
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from station.errors import cannot_write


def new_file(path: Path) -> tuple[BinaryIO, Writer]:
    """Return a new file and what writes into it; raise `CannotWrite` if it is there or cannot be made."""
    try:
        stream = path.open("xb")
    except OSError as error:
        raise cannot_write(path, error) from error
    writer = Writer(stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
    writer.start(profile="", library="station")
    return stream, writer


def new_channel(writer: Writer, topic: str, message: str, schema: bytes) -> int:
    """Return the number of a new channel of protobuf messages; ``schema`` describes them."""
    known = writer.register_schema(name=message, encoding="protobuf", data=schema)
    return writer.register_channel(topic=topic, message_encoding="protobuf", schema_id=known)
