"""XML from elsewhere: what reads files, asks hosts, grows or is too large is refused in a line."""

from pathlib import Path

import pytest

from station.errors import DataRefused
from station.files.xml_document import parse_xml, read_document
from tests.refusals import refused

LAUGHS = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10))
TRICKS = {
    "a file": '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>',
    "a host": '<!DOCTYPE a [<!ENTITY x SYSTEM "http://127.0.0.1:9/">]><a>&x;</a>',
    "laughs": f'<!DOCTYPE a [<!ENTITY a0 "ha">{LAUGHS}]><a>&a9;</a>',
    "in an attribute": f'<!DOCTYPE a [<!ENTITY a0 "ha">{LAUGHS}]><a b="&a9;"/>',
    "a parameter": '<!DOCTYPE a [<!ENTITY % x SYSTEM "http://127.0.0.1:9/x.dtd"> %x;]><a/>',
    "a DTD elsewhere": '<!DOCTYPE a SYSTEM "http://127.0.0.1:9/a.dtd"><a/>',
    "a plain DTD": "<!DOCTYPE a><a/>",
}


@pytest.mark.parametrize("name", TRICKS)
def test_entities_and_what_declares_them_are_refused(name: str) -> None:
    with refused(DataRefused, file="tricky.xml"):
        parse_xml(TRICKS[name].encode(), "tricky.xml")


@pytest.mark.parametrize(
    "content",
    [
        b"", b"<a>", b"<a>&x;</a>", "<a/>".encode("utf-16"), b'<?xml version="1.0" encoding="utf-7"?><a/>',
        b"<a>\xff</a>", b"<a>" * 3000 + b"</a>" * 3000, b"<a xmlns:x='y' x:b='1' x:b='2'/>",
    ],
)  # fmt: skip
def test_what_is_no_document_is_refused(content: bytes) -> None:
    with refused(DataRefused, file="bad.xml"):
        parse_xml(content, "bad.xml")


def test_a_document_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_bytes('\ufeff<?xml version="1.0" encoding="UTF-8"?><a>é</a>'.encode())
    assert parse_xml(read_document(tmp_path / "a.xml"), "a.xml").text == "é"


def test_a_hundred_megabytes_are_refused_unread(tmp_path: Path) -> None:
    file = tmp_path / "large.xml"
    with file.open("wb") as stream:
        stream.truncate(100_000_000)
    with refused(DataRefused, None, "100 MB", "32 MB"):
        read_document(file)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with refused(DataRefused):
        read_document(tmp_path / "none.xml")
