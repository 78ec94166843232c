"""The tables of ``fixtures/1``: what a file may say, checked as to type and unit by the column's name."""

from datetime import UTC, date, datetime
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict


def _aware(moment: datetime) -> datetime:
    if moment.tzinfo is None:
        raise ValueError("a moment with its time zone, such as 2026-03-04T12:00:00Z")
    return moment.astimezone(UTC)


Moment = Annotated[datetime, AfterValidator(_aware)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, coerce_numbers_to_str=True)


class CubeTable(_Table):
    """``[[cube]]``; the dates of a cube with certificates are those of the last one."""

    id: str
    side_mm: float
    certificate_date: date | None = None
    due_date: date | None = None


class ToleranceTable(_Table):
    """``[[tolerance]]``: an item of a cube's drawing."""

    cube_id: str
    item: str
    kind: str
    face: str
    reference_face: str | None = None
    tolerance_mm: float


class CertificateTable(_Table):
    """``[[certificate]]`` of a resting face: the up vector's components along the two other cube axes."""

    cube_id: str
    resting: str
    up_tilt_1_rad: float
    up_tilt_2_rad: float
    covariance_11_rad2: float
    covariance_12_rad2: float = 0.0
    covariance_22_rad2: float
    source: str
    measured_utc: Moment
    due_date: date | None = None


class MeasurementTable(_Table):
    """``[[measurement]]`` of a cube by IMUs: values by name, their covariance and sources, each as JSON."""

    cube_id: str
    values_rad: str
    covariance_rad2: str
    sources: str
    measured_utc: Moment
    due_date: date | None = None


class SlabTable(_Table):
    """``[[slab]]``; the dates of a slab with levels are those of the last one."""

    id: str
    certificate_date: date | None = None
    due_date: date | None = None


class LevelTable(_Table):
    """``[[level]]`` of a slab: the up vector's components seen from it."""

    slab_id: str
    tilt_east_rad: float
    tilt_north_rad: float
    std_east_rad: float
    std_north_rad: float
    source: str
    measured_utc: Moment
    due_date: date | None = None


class SiteTable(_Table):
    """``[[site]]``."""

    id: str
    latitude_deg: float
    longitude_deg: float | None = None
    height_m: float | None = None
    gravity_m_s2: float | None = None
    gravity_std_m_s2: float | None = None
    gravity_source: str | None = None
    gravity_date: date | None = None
    due_date: date | None = None


class ImuTable(_Table):
    """``[[imu]]``."""

    model: str
    serial: str


class FixturesTable(_Table):
    """The whole of a ``fixtures/1``."""

    format: str = "fixtures/1"
    cube: list[CubeTable] = []
    tolerance: list[ToleranceTable] = []
    certificate: list[CertificateTable] = []
    measurement: list[MeasurementTable] = []
    slab: list[SlabTable] = []
    level: list[LevelTable] = []
    site: list[SiteTable] = []
    imu: list[ImuTable] = []

    @property
    def rows(self) -> dict[str, list[dict[str, str | float | date | datetime | None]]]:
        """The rows by table, as `fixtures_db.transfer.restore` takes them."""
        return {name: [row.model_dump() for row in getattr(self, name)] for name in TABLES}


TABLES: dict[str, type[BaseModel]] = {
    "cube": CubeTable,
    "tolerance": ToleranceTable,
    "certificate": CertificateTable,
    "measurement": MeasurementTable,
    "slab": SlabTable,
    "level": LevelTable,
    "site": SiteTable,
    "imu": ImuTable,
}
