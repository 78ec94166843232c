"""Elements of a digital calibration certificate: made one within the other, texts in both languages."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

from lxml import etree

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
SCHEMA_VERSION = "3.1.2"
LANGUAGES = ("en", "de")
NOT_IN_XML = {code: " " for code in (*range(0x20), 0x7F, 0xFFFE, 0xFFFF) if code not in {0x09, 0x0A}}

Element: TypeAlias = etree._Element  # noqa: SLF001  lxml has no other name for it


@dataclass(frozen=True, slots=True)
class Said:
    """A text in both languages of the certificate."""

    en: str
    de: str

    def __add__(self, other: "Said") -> "Said":
        """Return this followed by another text, both languages."""
        return Said(self.en + other.en, self.de + other.de)


Text = Said | str
"""A text in both languages, or one of no language: a name, an address, what people wrote."""


def dcc(name: str, *inside: Element | None, text: str | None = None, **attributes: str | None) -> Element:
    """Return an element of the certificate's namespace with what is given ``inside`` of it; None is left out."""
    return _made(DCC, name, inside, text, attributes)


def si(name: str, *inside: Element | None, text: str | None = None) -> Element:
    """Return an element of the namespace of the D-SI."""
    return _made(SI, name, inside, text, {})


def worded(name: str, text: Text, **attributes: str | None) -> Element:
    """Return an element that holds a text: once for each language, once without one if it has none."""
    if isinstance(text, str):
        return dcc(name, dcc("content", text=text), **attributes)
    both = (dcc("content", text=getattr(text, lang), lang=lang) for lang in LANGUAGES)
    return dcc(name, *both, **attributes)


def joined(texts: Iterable[Said], between: str = "\n") -> Said:
    """Return several texts as one: an element holds one text of each language."""
    several = list(texts)
    return Said(*(between.join(getattr(one, lang) for one in several) for lang in LANGUAGES))


def _made(
    space: str, name: str, inside: Iterable[Element | None], text: str | None, attributes: dict[str, str | None]
) -> Element:
    made: Element = etree.Element(f"{{{space}}}{name}", nsmap={"dcc": DCC, "si": SI})
    for key, value in attributes.items():
        if value is not None:
            made.set(key, value)
    if text is not None:
        made.text = text.translate(NOT_IN_XML)
    made.extend(one for one in inside if one is not None)
    return made
