"""What is known of a cube: a certificate of its faces, its measurements, and whether it moved between them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy.orm import Session

from fixtures_db.cube_measurements import measurement, measurements
from fixtures_db.face_certificates import cube
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow
from procedures.bench.cube_drift import CubeComparison, CubeDrift, compare, drift
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import CubeMeasurement, from_certificate

DAYS_PER_MONTH = 365.25 / 12


@dataclass(frozen=True, slots=True, eq=False)
class KnownCube:
    """What the database says of a cube: its faces' certificate, and its measurements with their moments.

    ``sources`` has the SHA-256 of each measurement's campaigns.
    """

    certificate: MeasuredCube | None
    measured: tuple[tuple[datetime, CubeMeasurement], ...]
    sources: tuple[frozenset[str], ...]

    @property
    def drift(self) -> CubeDrift | None:
        """How the cube moved over its `independent` measurements; None of fewer than two."""
        return drift_of(self.independent)

    @property
    def independent(self) -> tuple[tuple[datetime, CubeMeasurement], ...]:
        """The measurements that share no campaign with an earlier one of them."""
        used, found = frozenset[str](), list[tuple[datetime, CubeMeasurement]]()
        for one, sources in zip(self.measured, self.sources, strict=True):
            if not used & sources:
                found.append(one)
                used |= sources
        return tuple(found)

    @property
    def comparison(self) -> CubeComparison | None:
        """The last measurement against the certificate; None where one of them lacks."""
        return compare(self.certificate, self.measured[-1][1].cube) if self.certificate and self.measured else None


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
        stored = zip(self.known.measured, self.known.sources, strict=True)
        this = ((self.measured_utc, self.measured), self.sources)
        measured, sources = zip(*sorted([*stored, this], key=lambda each: each[0][0]), strict=True)
        return KnownCube(self.known.certificate, measured, sources)

    @property
    def sources(self) -> frozenset[str]:
        """The SHA-256 of each campaign."""
        return frozenset(sha256 for each in self.campaigns.values() for sha256 in each.values())

    @property
    def stored_before(self) -> datetime | None:
        """When the same campaigns were stored as a measurement of this cube; None if they never were."""
        stored = zip(self.known.measured, self.known.sources, strict=True)
        return next((at for (at, _), sources in stored if sources == self.sources), None)


def known_of(session: Session, cube_id: str) -> KnownCube:
    """Return what the database says of a cube; raise `NotInDatabase` if it has none of that name."""
    row = fixture_row(session, CubeRow, cube_id)
    rows = measurements(row)
    measured = tuple((one.measured_utc, measurement(one)) for one in rows)
    sources = tuple(_sources(json.loads(one.sources)) for one in rows)
    return KnownCube(from_certificate(cube(session, cube_id).faces), measured, sources)


def _sources(units: Sequence[Mapping[str, Mapping[str, str]]]) -> frozenset[str]:
    return frozenset(sha256 for unit in units for sha256 in unit["campaigns"].values())


def drift_of(measured: Sequence[tuple[datetime, CubeMeasurement]]) -> CubeDrift | None:
    """Return how a cube moved over measurements with their moments, the earliest first."""
    if len(measured) < 2:
        return None
    months = [(at - measured[0][0]).total_seconds() / 86400 / DAYS_PER_MONTH for at, _ in measured]
    return drift([each for _, each in measured], months)
