"""Which quantities of a certificate are taken in: by refType, or by the names that laboratories give them.

``x_up`` is the cube resting with its x axis up; the components of its up vector are along the two other axes, in
the order x, y, z. docs/how-to/certificate-signing.md has the table.
"""

import re
from dataclasses import dataclass

from procedures.frames import FACES

AXES = "xyz"
NAMES = ("up tilt {} {}", "up tilt of {} along {}", "tilt of {} along {}", "neigung von {} entlang {}")


@dataclass(frozen=True, slots=True)
class Known:
    """What a quantity is: of a ``part``, which is a face, slab or the side, and which component of it, 0 or 1.

    ``component`` 2 is the correlation or covariance of both.
    """

    part: str
    component: int = 0


SIDE, SLAB = "side", "slab"


def _by_face() -> dict[str, Known]:
    known = dict[str, Known]()
    for face in FACES:
        others = [axis for axis in AXES if axis != face[0]]
        for at, axis in enumerate(others):
            here = Known(face, at)
            known[f"fog_upTilt_{face}_{axis}"] = here
            known |= {_plain(text.format(face, axis)): here for text in NAMES}
        both = (f"fog_upTiltCovariance_{face}", _plain(f"covariance of the up tilt of {face}"))
        known |= dict.fromkeys(both, Known(face, 2))
    return known


def _plain(text: str) -> str:
    """Return a name in small letters and digits, single blanks between: laboratories write them differently."""
    return " ".join(re.findall(r"[a-z0-9]+", text.casefold()))


KNOWN = _by_face() | {
    "fog_side": Known(SIDE), "side": Known(SIDE), "edge length": Known(SIDE),
    "kantenl nge": Known(SIDE),
    "fog_slabTilt_east": Known(SLAB), "tilt east": Known(SLAB), "tilt towards east": Known(SLAB),
    "neigung ost": Known(SLAB),
    "fog_slabTilt_north": Known(SLAB, 1), "tilt north": Known(SLAB, 1), "tilt towards north": Known(SLAB, 1),
    "neigung nord": Known(SLAB, 1),
}  # fmt: skip


def known_quantity(ref_types: str | None, names: list[str]) -> Known | None:
    """Return what a quantity is by its refTypes, else by its names in any language; None if it is not known."""
    by_type = [KNOWN[one] for one in (ref_types or "").split() if one.startswith("fog_") and one in KNOWN]
    by_name = [KNOWN[plain] for name in names if (plain := _plain(name)) in KNOWN]
    return next(iter([*by_type, *by_name]), None)
