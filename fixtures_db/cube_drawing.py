"""The tolerance items that a cube's drawing gives: Yao, Hu, He 2018, table 2."""

from collections.abc import Mapping

from fixtures_db.schema import ToleranceRow
from procedures.tolerance.drawing_items import DRAWING_ITEMS


def drawing(tolerances_mm: Mapping[str, float]) -> list[ToleranceRow]:
    """Return the items of a drawing by their names in the table; raise `ValueError` for one that is not there."""
    for item, value in tolerances_mm.items():
        if item not in DRAWING_ITEMS:
            raise ValueError(f"tolerance item {item!r} is none of {', '.join(DRAWING_ITEMS)}")
        if not value > 0:
            raise ValueError(f"tolerance {item} is {value} mm, expected more than 0")
    return [
        ToleranceRow(item=item, kind=kind, face=face, reference_face=reference, tolerance_mm=tolerances_mm[item])
        for item, (kind, face, reference) in DRAWING_ITEMS.items()
        if item in tolerances_mm
    ]
