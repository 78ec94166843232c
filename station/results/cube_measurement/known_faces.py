"""What is known of a cube: a certificate of its faces, its measurements, and whether it moved between them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

from sqlalchemy.orm import Session

from fixtures_db.fixture_measurements import cube, measurement, measurements
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow
from procedures.bench.cube_drift import CubeComparison, CubeDrift, compare, drift
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import CubeMeasurement, from_certificate

DAYS_PER_MONTH = 365.25 / 12


class StoredMeasurement(NamedTuple):
    """A measurement of a cube, its moment, and the SHA-256 of each campaign that it was made from."""

    measured_utc: datetime
    found: CubeMeasurement
    sources: frozenset[str]


@dataclass(frozen=True, slots=True, eq=False)
class KnownCube:
    """What the database says of a cube: its faces' certificate, and its measurements, the earliest first."""

    certificate: MeasuredCube | None
    measured: tuple[StoredMeasurement, ...]

    @property
    def drift(self) -> CubeDrift | None:
        """How the cube moved over its `independent` measurements; None of fewer than two."""
        return drift_of(self.independent)

    @property
    def independent(self) -> tuple[StoredMeasurement, ...]:
        """The measurements that share no campaign with an earlier one of them."""
        used, found = frozenset[str](), list[StoredMeasurement]()
        for one in self.measured:
            if not used & one.sources:
                found.append(one)
                used |= one.sources
        return tuple(found)

    @property
    def comparison(self) -> CubeComparison | None:
        """The last measurement against the certificate; None where one of them lacks."""
        return (
            compare(self.certificate, self.measured[-1].found.cube) if self.certificate and self.measured else None
        )


@dataclass(frozen=True, slots=True, eq=False)
class CubeStudy:
    """A cube as its campaigns show it, their hashes by unit and folder, and what was known before."""

    cube: str
    measured: CubeMeasurement
    measured_utc: datetime
    campaigns: Mapping[str, Mapping[str, str]]
    warnings: tuple[str, ...]
    known: KnownCube

    @property
    def with_this(self) -> KnownCube:
        """What is known when this is stored."""
        this = StoredMeasurement(self.measured_utc, self.measured, self.sources)
        by_date = sorted([*self.known.measured, this], key=lambda one: one.measured_utc)
        return KnownCube(self.known.certificate, tuple(by_date))

    @property
    def sources(self) -> frozenset[str]:
        """The SHA-256 of each campaign."""
        return frozenset(sha256 for each in self.campaigns.values() for sha256 in each.values())

    @property
    def stored_before(self) -> datetime | None:
        """When the same campaigns were stored as a measurement of this cube; None if they never were."""
        return next((one.measured_utc for one in self.known.measured if one.sources == self.sources), None)


def known_of(session: Session, cube_id: str) -> KnownCube:
    """Return what the database says of a cube; raise `NotInDatabase` if it has none of that name."""
    rows = measurements(fixture_row(session, CubeRow, cube_id))
    measured = tuple(
        StoredMeasurement(one.measured_utc, measurement(one), _sources(json.loads(one.sources))) for one in rows
    )
    return KnownCube(from_certificate(cube(session, cube_id).faces), measured)


def _sources(units: Sequence[Mapping[str, Mapping[str, str]]]) -> frozenset[str]:
    return frozenset(sha256 for unit in units for sha256 in unit["campaigns"].values())


def drift_of(measured: Sequence[StoredMeasurement]) -> CubeDrift | None:
    """Return how a cube moved over measurements, the earliest first."""
    if len(measured) < 2:
        return None
    first = measured[0].measured_utc
    months = [(one.measured_utc - first).total_seconds() / 86400 / DAYS_PER_MONTH for one in measured]
    return drift([one.found for one in measured], months)
