"""XML from elsewhere: no entities, no DTD, nothing fetched, UTF-8 alone, and not read where it is too large."""

from pathlib import Path
from typing import Any
from xml.sax import ContentHandler, SAXParseException

from defusedxml import DefusedXmlException
from defusedxml.sax import parseString
from lxml import etree

from station.errors import DataRefused

MOST_BYTES = 32_000_000  # a certificate with every figure of a campaign has less than 2 MB


def read_document(path: Path) -> bytes:
    """Return the bytes of a document; raise `DataRefused` if it is not there or, before reading, too large."""
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            found = f"{size / 1e6:.0f} MB"
            raise DataRefused(path, None, found, f"{MOST_BYTES / 1e6:.0f} MB at most", "give a certificate")
        return path.read_bytes()
    except OSError as error:
        raise DataRefused(path, None, f"no readable file ({error.strerror})", "a certificate") from error


def parse_xml(content: bytes, where: str | Path) -> Any:
    """Return the root element of a document.

    Raise `DataRefused` if it is no XML, no UTF-8, or has a DTD: entities are how a document reads files, hosts, or
    grows.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataRefused(where, None, "bytes that are no UTF-8", "XML in UTF-8") from error
    head = text[:200].split("?>")[0].lower()
    if head.startswith("<?xml") and "encoding" in head and "utf-8" not in head:
        raise DataRefused(where, None, "another encoding", "XML in UTF-8")
    try:
        parseString(content, ContentHandler(), forbid_dtd=True)  # before libxml2 sees any of it
        parser = etree.XMLParser(
            resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False, remove_blank_text=False
        )
        return etree.fromstring(content, parser)
    except DefusedXmlException as error:
        raise DataRefused(where, None, "a DTD or entities", "XML without", "do not trust the file") from error
    except SAXParseException as error:
        raise DataRefused(where, error.getLineNumber(), f"no XML ({error.getMessage()})", "a document") from error
    except etree.XMLSyntaxError as error:
        raise DataRefused(where, error.lineno, f"no XML ({error.msg})", "a document") from error
