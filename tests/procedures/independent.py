"""P1's geometry written a second time, from its tables, without `procedures.frames`: for tests to compare with."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, Fixture, ProcedureSigma, Site, TurnRecord
from procedures.campaign.observations import TriadDwells
from procedures.counts.count_rate import RateEstimate
from procedures.counts.sample_records import CountSeries
from procedures.units import STANDARD_GRAVITY

TABLE_1 = "UEN UWS DNE DSW SUW NUE WDS EDN NWU SEU ESD WND".split()  # P1, translated letter by letter
COMPASS = {"E": [1, 0, 0], "N": [0, 1, 0], "U": [0, 0, 1], "W": [-1, 0, 0], "S": [0, -1, 0], "D": [0, 0, -1]}
TABLE_4_K = np.array([1020.0, 1015.0, 1018.0])
TABLE_4_E = np.array([[0.999995, 0.001, 0.003], [0.002, 0.9999975, 0.001], [0.003, 0.002, 0.9999935]])
TABLE_4_D = np.array([0.001, 0.002, 0.001])
THETA = 0.04 / 400
NO_SERIES = CountSeries(np.zeros(0), None, None, np.zeros(0), 0.02)


def body_from_level(position: int) -> FloatArray:
    """Rows: body X, Y, Z in East-North-Up of a perfect cube."""
    return np.array([COMPASS[letter] for letter in TABLE_1[position - 1]], dtype=float)


def table_3(theta: float) -> FloatArray:
    """Specific force (12, 3) [g] of P1's table 3 with every item equal to ``theta``; row 4 as row 3."""
    c, s = np.cos, np.sin
    rows = [
        (c(theta), s(theta), 0), (-c(3 * theta), 0, s(3 * theta)),
        (0, c(3 * theta), s(3 * theta)), (s(5 * theta), -c(5 * theta), 0),
        (0, s(3 * theta), c(3 * theta)), (s(5 * theta), 0, -c(5 * theta)),
    ]  # fmt: skip
    return np.repeat(np.array(rows), 2, axis=0)


def table_3_faces(theta: float) -> FloatArray:
    """The same as up tilts (6, 2), x_up, x_down, ..."""
    return np.sin(theta * np.array([[1, 0], [0, 3], [0, 3], [5, 0], [0, 3], [5, 0]]))


def specific_force(
    faces: FloatArray, slab: FloatArray, headings: FloatArray, positions: Sequence[int]
) -> FloatArray:
    """Return (n, 3) [g]: up as the cube sees it, by components instead of rotations, exact to first order.

    The up vector seen from the slab leans by ``slab`` (E, N); the cube, turned by its heading, sees that lean
    along its horizontal axes, and on top of it the tilt of the face it stands on.
    """
    rows = []
    for position, heading in zip(positions, headings, strict=True):
        C = body_from_level(position)
        c, s = np.cos(heading), np.sin(heading)
        tilt = np.array([c * slab[0] + s * slab[1], -s * slab[0] + c * slab[1], 0.0])
        up = C[:, 2]
        across = C @ tilt
        vertical = int(np.argmax(np.abs(up)))
        others = [i for i in range(3) if i != vertical]
        across[others] += faces[2 * vertical + (0 if up[vertical] > 0 else 1)]
        rows.append(up * np.sqrt(1 - across @ across) + across)
    return np.array(rows)


def campaign(
    *, gravity_std: float = 1e-9, heading: float = 1e-3, fixture: Fixture | None = None,
    turns: tuple[TurnRecord, ...] = (), latitude: float = 0.55,
) -> Campaign:  # fmt: skip
    """A campaign without recordings: what the dwells showed is given apart."""
    site = Site(latitude, STANDARD_GRAVITY, gravity_std)
    return Campaign("M", "S", True, site, (), turns, ProcedureSigma(heading), fixture or Fixture())


def dwells(
    rate: FloatArray, std: FloatArray | float, positions: Sequence[int] = range(1, 13), number: int = 0
) -> TriadDwells:
    """Rates (n, 3) as `dwell_rates` would have returned them."""
    sigma = np.broadcast_to(np.asarray(std, dtype=float), rate.shape).copy()
    estimates = tuple(
        tuple(RateEstimate(float(r), float(s), 0, 1, 0, 1, 0, 9) for r, s in zip(row, row_std, strict=True))
        for row, row_std in zip(rate, sigma, strict=True)
    )
    steps = tuple((number, DwellRecord(f"dwell_{p:02d}", p, NO_SERIES)) for p in positions)
    return TriadDwells(steps, np.asarray(rate, dtype=float), sigma, np.full(3, 1e-3), estimates)
