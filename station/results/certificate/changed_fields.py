"""Which printed fields differ between two certificates, read from their HTML."""

import re
from html import unescape

FIELDS_THAT_ALWAYS_CHANGE = {
    "Issued",
    "Newest calibration",
    "Newest face certificate",
    "Newest surface plate level",
    "Certificate before this",
    "Journal of the database",
}


TABLE = re.compile(r'<table(?: class="([^"]*)")?[^>]*>(.*?)</table>', re.DOTALL)
CELL = re.compile(r"<t[hd]\b[^>]*>(.*?)</t[hd]>", re.DOTALL)
TAG = re.compile(r"<[^>]*>")


def changed_fields(before: str, now: str) -> list[str]:
    """Return the labels of the fields that two certificates print otherwise, in the order of the newer."""
    old, new = _fields(before), _fields(now)
    names = [*new, *(name for name in old if name not in new)]
    return [name for name in names if old.get(name) != new.get(name) and name not in FIELDS_THAT_ALWAYS_CHANGE]


def _fields(html: str) -> dict[str, list[str]]:
    found = dict[str, list[str]]()
    for table, row in ((table, row) for table, rows in TABLE.findall(html) for row in rows.split("<tr>")[1:]):
        texts = [" ".join(unescape(TAG.sub("", cell)).split()) for cell in CELL.findall(row)]
        if table == "house":
            found["Laboratory"] = texts
        elif table.startswith("facts"):
            for label, text in zip(texts[::2], texts[1::2], strict=False):
                found.setdefault(label, []).append(text)
        elif table in {"references", "signature"} and texts[0]:
            found.setdefault(texts[0] if table == "references" else "Authorised by", []).append(" ".join(texts))
    return found
