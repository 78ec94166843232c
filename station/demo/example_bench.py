"""The bench of a simulated unit in a database: its cube and slab as measured, its site as surveyed, its limits.

The values are those of a truth plus a draw of the sigma that is stated; every source says that nobody measured
them.
"""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from sqlalchemy.orm import Session

from drivers.simulated.truth import Truth
from fixtures_db.fixture_measurements import add_level, certify_faces, face_certificate, faces_in_force
from fixtures_db.fixtures import add_fixture
from fixtures_db.imu_models import limits_of, set_limits
from fixtures_db.schema import CubeRow, SiteRow, SlabLevelRow, SlabRow
from procedures.campaign.campaign import FaceCertificate
from procedures.positions import FACES
from station.errors import DataRefused
from station.files.limits_file import example_limits, limits_in

SOURCE = "simulated: nobody measured it"
SIDE_MM = 400.0
FACE_STD = 5e-6  # rad, 1 arcsec: a good measuring machine on 400 mm
LEVEL_STD = 5e-6  # rad
GRAVITY_STD = 1e-5  # m/s2
HOLDS = timedelta(days=365)
FAR_OFF = 6.0  # sigma of a face: no draw of this bench


@dataclass(frozen=True, slots=True)
class ExampleBench:
    """The names of a simulated unit's cube, slab and site, and the truth they belong to."""

    cube: str
    slab: str
    site: str
    truth: Truth


def add_example(session: Session, seed: int) -> ExampleBench:
    """Add what is not there yet of the bench of the unit `Truth.example` makes of a seed."""
    return _add(session, Truth.example(seed), str(seed), np.random.default_rng([seed, 0xCE27]))


def add_bench_of(session: Session, truth: Truth) -> ExampleBench:
    """Add what is not there yet of the bench of a truth, named by its serial number.

    Raises
    ------
    DataRefused
        If cube or site of that serial number are there already and are not the truth's.
    """
    name = truth.serial
    if (differs := _differing(session, truth, name)) is not None:
        expected, remedy = "the bench of this truth", "give the truth another serial, or take another database"
        raise DataRefused(differs, None, "another bench in the database", expected, remedy)
    return _add(session, truth, name, np.random.default_rng([*name.encode(), 0xCE27]))


def _differing(session: Session, truth: Truth, name: str) -> str | None:
    """Return the cube or site of a name in the database that is not the truth's."""
    cube, site = session.get(CubeRow, f"SIM-CUBE-{name}"), session.get(SiteRow, f"SIM-SITE-{name}")
    for resting, row in (faces_in_force(cube) if cube is not None else {}).items():
        face = face_certificate(row)
        off = face.up_tilt - truth.faces_rad[FACES.index(resting)]
        if off @ np.linalg.solve(face.covariance, off) > FAR_OFF**2:
            return f"cube SIM-CUBE-{name}"
    stated = (truth.latitude_deg, truth.local_gravity)
    return None if site is None or (site.latitude_deg, site.gravity_m_s2) == stated else f"site {site.id}"


def _add(session: Session, truth: Truth, name: str, rng: np.random.Generator) -> ExampleBench:
    """Add what is not there yet; limits that the model has stay."""
    made = ExampleBench(f"SIM-CUBE-{name}", f"SIM-SLAB-{name}", f"SIM-SITE-{name}", truth)
    now = datetime.now(UTC)
    due = (now + HOLDS).date()
    tilts = truth.faces_rad + FACE_STD * rng.standard_normal((6, 2))
    east, north = (truth.slab_tilt_rad + LEVEL_STD * rng.standard_normal(2)).tolist()
    if session.get(CubeRow, made.cube) is None:
        add_fixture(session, CubeRow(id=made.cube, side_mm=SIDE_MM))
        faces = {face: FaceCertificate(tilts[i], FACE_STD**2 * np.eye(2)) for i, face in enumerate(FACES)}
        certify_faces(session, made.cube, faces, source=SOURCE, measured_utc=now, due_date=due)
    if session.get(SlabRow, made.slab) is None:
        add_fixture(session, SlabRow(id=made.slab))
        level = SlabLevelRow(
            slab_id=made.slab, tilt_east_rad=east, tilt_north_rad=north, std_east_rad=LEVEL_STD,
            std_north_rad=LEVEL_STD, source=SOURCE, measured_utc=now, due_date=due,
        )  # fmt: skip
        add_level(session, level)
    if session.get(SiteRow, made.site) is None:
        site = SiteRow(
            id=made.site, latitude_deg=truth.latitude_deg, longitude_deg=truth.longitude_deg,
            height_m=truth.height_m, gravity_m_s2=truth.local_gravity, gravity_std_m_s2=GRAVITY_STD,
            gravity_source=SOURCE, gravity_date=now.date(), due_date=due,
        )  # fmt: skip
        add_fixture(session, site)
    if not limits_of(session, truth.model):
        _, limits = limits_in(example_limits(truth.model).encode(), Path("the sample"))
        set_limits(session, truth.model, limits)
    return made
