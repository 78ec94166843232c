"""XML from elsewhere: what reads files, asks hosts, grows or is too large is refused in a line."""

from pathlib import Path

import pytest

from station.errors import DataRefused
from station.files.xml_document import parse_xml, read_document

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
    with pytest.raises(DataRefused, match="found a DTD or entities, expected XML without"):
        parse_xml(TRICKS[name].encode(), "tricky.xml")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no XML"),
        (b"<a>", "no XML"),
        (b"<a>&x;</a>", "no XML"),
        ("<a/>".encode("utf-16"), "expected XML in UTF-8"),
        (b'<?xml version="1.0" encoding="utf-7"?><a/>', "expected XML in UTF-8"),
        (b"<a>\xff</a>", "expected XML in UTF-8"),
        (b"<a>" * 3000 + b"</a>" * 3000, "no XML"),
        (b"<a xmlns:x='y' x:b='1' x:b='2'/>", "no XML"),
    ],
)
def test_what_is_no_document_is_refused(content: bytes, said: str) -> None:
    with pytest.raises(DataRefused) as caught:
        parse_xml(content, "bad.xml")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_document_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_bytes('\ufeff<?xml version="1.0" encoding="UTF-8"?><a>é</a>'.encode())
    assert parse_xml(read_document(tmp_path / "a.xml"), "a.xml").text == "é"


def test_a_hundred_megabytes_are_refused_unread(tmp_path: Path) -> None:
    file = tmp_path / "large.xml"
    with file.open("wb") as stream:
        stream.truncate(100_000_000)
    with pytest.raises(DataRefused, match=r"large\.xml: found 100 MB, expected 32 MB at most"):
        read_document(file)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataRefused, match="no readable file"):
        read_document(tmp_path / "none.xml")
