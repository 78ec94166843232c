"""What a digital certificate says, read with lxml alone and none of the code that wrote it."""

from dataclasses import dataclass

from lxml import etree

NS = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}


@dataclass(frozen=True)
class Read:
    """A quantity as read: value, U and k None where it has none, its unit."""

    value: float
    unit: str
    expanded: float | None
    factor: float | None
    dof: float | None


def parsed(content: bytes) -> etree._Element:
    return etree.fromstring(content)


def of_type(root: etree._Element, ref_type: str, tag: str = "*") -> list[etree._Element]:
    """Return the elements that have a refType among theirs."""
    found = root.iterfind(f".//dcc:{tag}", NS) if tag != "*" else root.iter("{https://ptb.de/dcc}*")
    return [one for one in found if ref_type in one.get("refType", "").split()]


def read(quantity: etree._Element) -> Read:
    def number(path: str) -> float | None:
        text = quantity.findtext(path, None, NS)
        return None if text is None else float(text)

    value = number("si:real/si:value")
    assert value is not None
    dofs = of_type(quantity, "fog_effectiveDegreesOfFreedom", "metaData")
    dof = None if not dofs else float(dofs[0].findtext(".//si:value", None, NS))
    return Read(
        value, quantity.findtext("si:real/si:unit", None, NS), number("si:real/si:expandedUnc/si:uncertainty"),
        number("si:real/si:expandedUnc/si:coverageFactor"), dof,
    )  # fmt: skip


def results(root: etree._Element) -> dict[str, Read]:
    """Return the parameters by name."""
    found = of_type(root, "basic_measuredValue", "quantity")
    return {one.get("id"): read(one) for one in found}


def all_numbers(root: etree._Element) -> set[float]:
    """Return every number of the certificate."""
    texts = [one.text or "" for one in root.iter("{https://ptb.de/si}*") if len(one) == 0]
    return {float(word) for text in texts for word in text.split() if _is_number(word)}


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
