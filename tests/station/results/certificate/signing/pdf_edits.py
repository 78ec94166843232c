"""Edits of a signed PDF: of its bytes, of what is appended to it, and of the document attached to it."""

import random
import re
from collections.abc import Callable
from io import BytesIO

from pyhanko.pdf_utils import generic
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter

Edit = Callable[[bytes, random.Random], bytes]


def gap(pdf: bytes) -> tuple[int, int]:
    """Where the signature's own value stands."""
    before, after = re.findall(rb"/ByteRange\s*\[\s*0\s+(\d+)\s+(\d+)", pdf)[-1]
    return int(before), int(after)


def place(pdf: bytes, chance: random.Random) -> int:
    """A byte that is not of the signature's value."""
    before, after = gap(pdf)
    at = chance.randrange(len(pdf) - (after - before))
    return at if at < before else at + after - before


def byte(pdf: bytes, chance: random.Random) -> bytes:
    at = place(pdf, chance)
    return pdf[:at] + bytes([pdf[at] ^ chance.randrange(1, 256)]) + pdf[at + 1 :]


def inserted(pdf: bytes, chance: random.Random) -> bytes:
    at = place(pdf, chance)
    return pdf[:at] + chance.randbytes(chance.randrange(1, 9)) + pdf[at:]


def cut(pdf: bytes, chance: random.Random) -> bytes:
    at = place(pdf, chance)
    return pdf[:at] + pdf[at + chance.randrange(1, 9) :]


def ended(pdf: bytes, chance: random.Random) -> bytes:
    return pdf[: chance.randrange(len(pdf))]


def appended(pdf: bytes, chance: random.Random) -> bytes:
    return pdf + chance.choice([b"\n", b"%%EOF\n", chance.randbytes(20), pdf[-50:]])


def updated(pdf: bytes, chance: random.Random) -> bytes:
    """An increment of PDF that says who wrote it, or gives the first page another content."""
    writer = IncrementalPdfFileWriter(BytesIO(pdf))
    if chance.random() < 0.5:
        writer.set_info(generic.DictionaryObject({generic.pdf_name("/Author"): generic.pdf_string("X")}))
    else:
        stream = generic.StreamObject(stream_data=b"BT ET")
        page = writer.root["/Pages"]["/Kids"][0]
        page[generic.pdf_name("/Contents")] = writer.add_object(stream)
        writer.update_container(page)
    out = BytesIO()
    writer.write(out)
    return out.getvalue()


def attachment(pdf: bytes, chance: random.Random) -> bytes:
    """An increment with another document attached."""
    writer = IncrementalPdfFileWriter(BytesIO(pdf))
    spec = writer.root["/Names"]["/EmbeddedFiles"]["/Names"][1]
    data = spec["/EF"]["/F"].data
    at = chance.randrange(len(data))
    stream = generic.StreamObject(stream_data=data[:at] + b"7" + data[at + 1 :] + b" ")
    spec["/EF"][generic.pdf_name("/F")] = writer.add_object(stream)
    writer.update_container(spec)
    out = BytesIO()
    writer.write(out)
    return out.getvalue()


def signature(pdf: bytes, chance: random.Random) -> bytes:
    """Another bit at the head of the signature's value, or of the zeros behind it."""
    before, after = gap(pdf)
    if chance.random() < 0.5:
        return pdf[: after - 3] + b"41" + pdf[after - 1 :]
    value = bytearray.fromhex(pdf[before + 1 : after - 1].decode())
    value[chance.randrange(10)] ^= 1 << chance.randrange(8)
    return pdf[: before + 1] + value.hex().encode() + pdf[after - 1 :]


EDITS: dict[str, Edit] = {
    "byte": byte, "inserted": inserted, "cut": cut, "ended": ended, "appended": appended, "updated": updated,
    "attachment": attachment, "signature": signature,
}  # fmt: skip
