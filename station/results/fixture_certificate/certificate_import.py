"""A read certificate into the database: as certificates of a cube's faces, or as a level of a slab."""

from dataclasses import replace
from datetime import UTC, date, datetime, time
from pathlib import Path

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.fixture_measurements import add_level, certify_faces
from fixtures_db.fixtures import add_fixture, fixture_rows
from fixtures_db.schema import CubeRow, SlabLevelRow, SlabRow
from procedures.campaign.campaign import FaceCertificate
from station.errors import DataRefused
from station.results.certificate.signing.verification import UNSIGNED, Verified
from station.results.fixture_certificate.fixture_document import FixtureDocument
from station.results.fixture_certificate.known_already import refuse_known
from station.results.fixture_certificate.quantity_names import SLAB

METRES_PER_MM = 1e-3


def refuse_unproven(found: Verified, where: str | Path, unsigned: bool) -> str:
    """Return how a certificate is proven, in words to be stored with it.

    Raises
    ------
    DataRefused
        If its signature does not hold or is not trusted; if it has none, unless ``unsigned`` ones are taken.
    """
    faults = dict(found.faults)
    if unsigned and UNSIGNED in found.findings:
        del faults["signature"]
    for name, words in faults.items():
        remedy, expected = "get it again from the laboratory", "a certificate that is signed and trusted"
        if UNSIGNED in found.findings and name == "signature":
            remedy = "ask the laboratory for a signed one, or give --unsigned"
        elif name == "key":
            remedy = "give --trust ROOT.pem, a root that you trust"
        elif name == "schema":
            expected = "a certificate that is valid"
        raise DataRefused(where, None, f"{name}: {words.removeprefix('found ')}", expected, remedy)
    if UNSIGNED in found.findings:
        return "imported unsigned"
    key = next(one.words for one in found.findings if one.name == "key")
    return f"signed by {key.partition(', valid ')[0]}"


def take_in(session: Session, read: FixtureDocument, proven: str, due: date | None, where: str | Path) -> str:
    """Append what a certificate says and return it in words; call it in `fixtures_db.database.Database.write`.

    Raises
    ------
    DataRefused
        If it is of nothing that is known, in there already, of a day to come, or was due before it was measured.
    """
    read = replace(read, due=due or read.due)
    source = f"{read.laboratory}, certificate No. {read.number}, {proven}"
    _refuse_days(read, where)
    refuse_known(session, read, where)
    at = datetime.combine(read.measured, time(12), UTC)
    held = f", due {read.due}" if read.due is not None else ", without a due date: import it again with --due"
    if (level := read.tilts.get(SLAB)) is not None:
        name = _named(session, SlabRow, read, where) or _added_slab(session, read, where)
        std = np.sqrt(np.diag(level.covariance)).tolist()
        east, north = level.value.tolist()
        row = SlabLevelRow(
            slab_id=name, tilt_east_rad=east, tilt_north_rad=north, std_east_rad=std[0], std_north_rad=std[1],
            source=source, measured_utc=at, due_date=read.due,
        )  # fmt: skip
        add_level(session, row)
        return f"level of surface plate {name} ({source}{held})"
    name = _named(session, CubeRow, read, where) or _added_cube(session, read, where)
    faces = {face: FaceCertificate(tilt.value, tilt.covariance) for face, tilt in read.tilts.items()}
    certify_faces(session, name, faces, source=source, measured_utc=at, due_date=read.due)
    return f"certificate of {', '.join(faces)} of cube {name} ({source}{held})"


def _refuse_days(read: FixtureDocument, where: str | Path) -> None:
    if read.measured > max(date.today(), datetime.now(UTC).date()):
        raise DataRefused(where, None, f"measured on {read.measured}", "a day that has been")
    if read.due is not None and read.due < read.measured:
        raise DataRefused(where, None, f"due {read.due}", f"{read.measured} or later, when it was measured")


def _named(
    session: Session, kind: type[CubeRow] | type[SlabRow], read: FixtureDocument, where: str | Path
) -> str | None:
    """Return the fixture that a certificate's item is by one of its identifications; None if it is new."""
    known = [row.id for row in fixture_rows(session, kind)]
    found = sorted({one for one in read.items if one in known})
    if len(found) > 1:
        raise DataRefused(where, None, f"items {', '.join(found)}", "one of them")
    return found[0] if found else None


def _new_name(read: FixtureDocument, where: str | Path) -> str:
    if len(names := sorted({one for one in read.items if one})) != 1:
        said = ", ".join(names) or "none"
        raise DataRefused(where, None, f"items {said}", "one that is in the database", "add it by `fixtures add`")
    return names[0]


def _added_slab(session: Session, read: FixtureDocument, where: str | Path) -> str:
    return add_fixture(session, SlabRow(id=_new_name(read, where))).id


def _added_cube(session: Session, read: FixtureDocument, where: str | Path) -> str:
    name = _new_name(read, where)
    if read.side is None:
        found = f"cube {name}, which is not in the database, without its side"
        raise DataRefused(where, None, found, "one that is, or its side", f"`station fixtures add cube {name}`")
    return add_fixture(session, CubeRow(id=name, side_mm=read.side / METRES_PER_MM)).id
