"""Edits of a signed document that change what it says: each changes a root by a source of chance."""

import random
from base64 import b64decode, b64encode
from collections.abc import Callable
from typing import Any

from lxml import etree

from station.results.certificate.signing.xml_schema import ds, xades

Edit = Callable[[Any, random.Random], None]


def outside(root: Any) -> list[Any]:
    """The elements that are not of the signature."""
    inside = {one for signature in root.iter(ds("Signature")) for one in signature.iter()}
    return [one for one in root.iter(etree.Element) if one not in inside]


def content(root: Any, chance: random.Random) -> None:
    """Another character in a text, one more or one less."""
    element = chance.choice([one for one in outside(root) if one.text and one.text.strip()])
    at = chance.randrange(len(element.text))
    put = chance.choice(["", "7", "x", " ", element.text[at] + "\u00a0"])
    new = element.text[:at] + put + element.text[at + 1 :]
    element.text = new if new != element.text else new + "0"


def number(root: Any, chance: random.Random) -> None:
    """Another digit in a number."""
    element = chance.choice([one for one in outside(root) if one.text and any(map(str.isdigit, one.text))])
    places = [i for i, letter in enumerate(element.text) if letter.isdigit()]
    at = chance.choice(places)
    digit = chance.choice([one for one in "0123456789" if one != element.text[at]])
    element.text = element.text[:at] + digit + element.text[at + 1 :]


def attribute(root: Any, chance: random.Random) -> None:
    """Another value of an attribute, one that was not there, or one gone."""
    element = chance.choice(outside(root))
    names = list(element.attrib)
    way = chance.choice(["add", "change", "remove"]) if names else "add"
    if way == "add":
        element.set(f"added{len(names)}", "1")
    elif way == "change":
        name = chance.choice(names)
        element.set(name, element.get(name) + "1")
    else:
        del element.attrib[chance.choice(names)]


def order(root: Any, chance: random.Random) -> None:
    """Two neighbours the other way round, an element twice, or one gone."""
    parents = [one for one in outside(root) if sum(isinstance(c.tag, str) for c in one) > 1]
    parent = chance.choice(parents)
    at = chance.randrange(len(parent) - 1)
    first, second = parent[at], parent[at + 1]
    way = chance.choice(["swap", "twice", "gone"])
    if way == "twice" or second.tag == ds("Signature") or etree.tostring(first) == etree.tostring(second):
        parent.insert(at, etree.fromstring(etree.tostring(first)))
    elif way == "gone":
        parent.remove(first)
    else:
        parent.remove(second)
        parent.insert(at, second)


def comment(root: Any, chance: random.Random) -> None:
    """A comment within a value: some readers then read half of it."""
    element = chance.choice(
        [one for one in outside(root) if one.text and len(one.text.strip()) > 1 and not len(one)]
    )
    half = max(1, len(element.text) // 2)
    inserted = etree.Comment("")
    inserted.tail, element.text = element.text[half:], element.text[:half]
    element.insert(0, inserted)


def name(root: Any, chance: random.Random) -> None:
    """Another name or namespace of an element."""
    element = chance.choice([one for one in outside(root) if one is not root])
    element.tag = chance.choice([element.tag + "s", "{https://ptb.de/si/v1}" + etree.QName(element).localname])


def signature(root: Any, chance: random.Random) -> None:
    """Another bit of the signature: a digest, its value, a certificate, its time, the time stamp."""
    (found,) = root.iter(ds("Signature"))
    names = {ds("DigestValue"), ds("SignatureValue"), ds("X509Certificate"), xades("EncapsulatedTimeStamp")}
    element = chance.choice([one for one in found.iter() if one.tag in names])
    held = bytearray(b64decode(element.text))
    # of a token what its service signed and the signature, at its end: certificates that came with it are neither
    whole = element.tag != xades("EncapsulatedTimeStamp")
    held[chance.randrange(len(held)) if whole else -1 - chance.randrange(256)] ^= 1 << chance.randrange(8)
    element.text = b64encode(held).decode()


def moved(root: Any, chance: random.Random) -> None:
    """The signature elsewhere, twice, or gone."""
    (found,) = root.iter(ds("Signature"))
    way = chance.choice(["elsewhere", "twice", "gone"])
    if way == "twice":
        found.addnext(etree.fromstring(etree.tostring(found)))
    elif way == "gone":
        found.getparent().remove(found)
    else:
        chance.choice([one for one in outside(root) if one is not found.getparent() and one is not root]).append(
            found
        )


EDITS: dict[str, Edit] = {
    "content": content, "number": number, "attribute": attribute, "order": order, "comment": comment,
    "name": name, "signature": signature, "moved": moved,
}  # fmt: skip
