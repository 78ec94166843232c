"""A statement of a digital certificate, in both languages."""

from station.results.certificate.dcc.elements import Element, Said, dcc, worded


def statement(ref_type: str, text: Said, *beside: Element | None, norm: tuple[str, ...] = ()) -> Element:
    """Return a statement; ``beside`` stands after its text, in the order of the schema."""
    norms = (dcc("norm", text=one) for one in norm)
    return dcc("statement", *norms, worded("declaration", text), *beside, refType=ref_type)
