"""The tolerance items that a cube's drawing gives: Yao, Hu, He 2018, table 2."""

from collections.abc import Mapping

from fixtures_db.schema import ToleranceRow

DRAWING_ITEMS = {  # item: what of which face, against which
    "t1": ("flatness", "A", None),
    "t2": ("flatness", "B", None),
    "t3": ("flatness", "C", None),
    "t4-1": ("perpendicularity", "C", "A"),
    "t4-2": ("perpendicularity", "C", "B"),
    "t5": ("flatness", "opposite A", None),
    "t6": ("flatness", "opposite B", None),
    "t7": ("flatness", "opposite C", None),
    "t8": ("parallelism", "opposite A", "A"),
    "t9": ("parallelism", "opposite B", "B"),
    "t10": ("parallelism", "opposite C", "C"),
}


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
