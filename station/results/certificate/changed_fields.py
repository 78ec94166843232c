"""Which printed fields differ between two certificates, read from their HTML."""

from html.parser import HTMLParser

FIELDS_THAT_ALWAYS_CHANGE = {
    "Issued",
    "Newest calibration",
    "Newest face certificate",
    "Newest slab level",
    "Certificate before this",
}


class _PrintedFields(HTMLParser):
    """Collects the cells of every row of every table."""

    def __init__(self) -> None:
        super().__init__()
        self.rows = list[tuple[str, list[tuple[str, str]]]]()
        self._table, self._open = "", False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "table":
            self._table = dict(attrs).get("class") or ""
        elif tag == "tr":
            self.rows.append((self._table, []))
        elif tag in {"th", "td"} and self.rows:
            self.rows[-1][1].append((tag, ""))
            self._open = True

    def handle_endtag(self, tag: str) -> None:
        self._open = self._open and tag not in {"th", "td"}

    def handle_data(self, data: str) -> None:
        if self._open:
            tag, text = self.rows[-1][1][-1]
            self.rows[-1][1][-1] = (tag, text + data)


def changed_fields(before: str, now: str) -> list[str]:
    """Return the labels of the fields that two certificates print otherwise, in the order of the newer."""
    old, new = _fields(before), _fields(now)
    names = [*new, *(name for name in old if name not in new)]
    return [name for name in names if old.get(name) != new.get(name) and name not in FIELDS_THAT_ALWAYS_CHANGE]


def _fields(html: str) -> dict[str, list[str]]:
    parser, found = _PrintedFields(), dict[str, list[str]]()
    parser.feed(html)
    for table, cells in parser.rows:
        texts = [" ".join(text.split()) for _, text in cells]
        if table == "house":
            found["Laboratory"] = texts
        elif table.startswith("facts"):
            for label, text in zip(texts[::2], texts[1::2], strict=False):
                found.setdefault(label, []).append(text)
        elif table in {"references", "signature"} and texts[0]:
            found.setdefault(texts[0] if table == "references" else "Authorised by", []).append(" ".join(texts))
    return found
