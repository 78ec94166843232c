"""A laboratory names its quantities by refType, in English or in German."""

import pytest

from station.results.fixture_certificate.quantity_names import SIDE, SLAB, Known, known_quantity


@pytest.mark.parametrize(
    ("ref_type", "names", "known"),
    [
        ("fog_slabTilt_east", ["Tilt East", "Tilt towards East", "Neigung Ost"], Known(SLAB, 0)),
        ("fog_slabTilt_north", ["Tilt north", "tilt towards North", "Neigung  Nord"], Known(SLAB, 1)),
        ("fog_side", ["Side", "Edge length", "Kantenl\u00e4nge"], Known(SIDE)),
        ("fog_upTiltCovariance_x_up", ["Covariance of the up tilt of x_up"], Known("x_up", 2)),
    ],
)
def test_every_name_of_a_quantity_means_the_same(ref_type: str, names: list[str], known: Known) -> None:
    assert known_quantity(f"other {ref_type}", ["a length"]) == known
    assert [known_quantity(None, ["?", name]) for name in names] == [known] * len(names)
    assert known_quantity("fog_other", ["another"]) is None
