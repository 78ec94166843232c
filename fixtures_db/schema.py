"""The tables, typed. Migrations create them (``migrations/versions``); a test holds the two equal.

A unit is part of a column's name. `ChainedRow`s are never changed: triggers refuse it.
"""

from datetime import UTC, date, datetime

from sqlalchemy import JSON, Date, DateTime, Dialect, Double, ForeignKey, MetaData, String, Text, UniqueConstraint
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column, relationship
from sqlalchemy.types import TypeDecorator

NAMING = {  # of migrations as well: never to be changed
    "ix": "ix_%(table_name)s_%(column_0_name)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
    "ck": "ck_%(table_name)s_%(constraint_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
}
SHA256 = String(64)


class UtcDateTime(TypeDecorator[datetime]):
    """A moment in UTC; one without a time zone is refused, not guessed."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Return the moment in UTC, as SQLite stores it: without a zone."""
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError(f"{value!r} has no time zone; expected an aware datetime")
        value = value.astimezone(UTC)
        return value.replace(tzinfo=None) if dialect.name == "sqlite" else value

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Return the stored moment as an aware datetime in UTC."""
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


class Base(DeclarativeBase):
    """The registry of all tables."""

    metadata = MetaData(naming_convention=NAMING)
    type_annotation_map = {datetime: UtcDateTime, date: Date, float: Double, dict[str, str]: JSON}


class ChainedRow:
    """Columns of a row that is never changed: the hash of the row before it, and its own."""

    previous: Mapped[str] = mapped_column(SHA256, unique=True, sort_order=2)
    sha256: Mapped[str] = mapped_column(SHA256, unique=True, sort_order=2)


class Measured(ChainedRow):
    """A chained row of something that was measured, and until when it holds."""

    measured_utc: Mapped[datetime] = mapped_column(sort_order=1)
    due_date: Mapped[date | None] = mapped_column(sort_order=1)


class CubeRow(Base):
    """A cube fixture; ``side_mm`` is the length of its edge."""

    __tablename__ = "cubes"
    id: Mapped[str] = mapped_column(primary_key=True)
    side_mm: Mapped[float]
    certificate_date: Mapped[date | None]
    due_date: Mapped[date | None]
    tolerances: Mapped[list["ToleranceRow"]] = relationship(order_by="ToleranceRow.id")
    certificates: Mapped[list["FaceCertificateRow"]] = relationship(order_by="FaceCertificateRow.id")
    measurements: Mapped[list["CubeMeasurementRow"]] = relationship(order_by="CubeMeasurementRow.id")


class ToleranceRow(Base):
    """A tolerance item of Yao, Hu, He 2018, table 2: ``t1`` ... ``t10``, on a face."""

    __tablename__ = "tolerance_items"
    __table_args__ = (UniqueConstraint("cube_id", "item"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    cube_id: Mapped[str] = mapped_column(ForeignKey("cubes.id"))
    item: Mapped[str]
    kind: Mapped[str]
    face: Mapped[str]
    reference_face: Mapped[str | None]
    tolerance_mm: Mapped[float]


class FaceCertificateRow(Measured, Base):
    """A measured resting face: the up vector along the two other cube axes, with covariance."""

    __tablename__ = "face_certificates"
    id: Mapped[int] = mapped_column(primary_key=True)
    cube_id: Mapped[str] = mapped_column(ForeignKey("cubes.id"), index=True)
    resting: Mapped[str]
    up_tilt_1_rad: Mapped[float]
    up_tilt_2_rad: Mapped[float]
    covariance_11_rad2: Mapped[float]
    covariance_12_rad2: Mapped[float]
    covariance_22_rad2: Mapped[float]
    source: Mapped[str]


class CubeMeasurementRow(Measured, Base):
    """What IMUs measured of a cube, as JSON texts: values by name, their covariance, sources."""

    __tablename__ = "cube_measurements"
    id: Mapped[int] = mapped_column(primary_key=True)
    cube_id: Mapped[str] = mapped_column(ForeignKey("cubes.id"), index=True)
    values_rad: Mapped[str] = mapped_column(Text)
    covariance_rad2: Mapped[str] = mapped_column(Text)
    sources: Mapped[str] = mapped_column(Text)


class SlabRow(Base):
    """A marble slab."""

    __tablename__ = "slabs"
    id: Mapped[str] = mapped_column(primary_key=True)
    certificate_date: Mapped[date | None]
    due_date: Mapped[date | None]
    levels: Mapped[list["SlabLevelRow"]] = relationship(order_by="SlabLevelRow.id")


class SlabLevelRow(Measured, Base):
    """A slab's tilt as measured: the up normal's east and north components, each with 1 sigma."""

    __tablename__ = "slab_levels"
    id: Mapped[int] = mapped_column(primary_key=True)
    slab_id: Mapped[str] = mapped_column(ForeignKey("slabs.id"), index=True)
    tilt_east_rad: Mapped[float]
    tilt_north_rad: Mapped[float]
    std_east_rad: Mapped[float]
    std_north_rad: Mapped[float]
    source: Mapped[str]


class SiteRow(Base):
    """Where a slab stands: geodetic position, surveyed gravity and its 1 sigma, by whom and until when."""

    __tablename__ = "sites"
    id: Mapped[str] = mapped_column(primary_key=True)
    latitude_deg: Mapped[float]
    longitude_deg: Mapped[float | None]
    height_m: Mapped[float | None]
    gravity_m_s2: Mapped[float | None]
    gravity_std_m_s2: Mapped[float | None]
    gravity_source: Mapped[str | None]
    gravity_date: Mapped[date | None]
    due_date: Mapped[date | None]


class ImuRow(Base):
    """An IMU, known by model and serial number."""

    __tablename__ = "imus"
    __table_args__ = (UniqueConstraint("model", "serial"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    model: Mapped[str]
    serial: Mapped[str] = mapped_column(index=True)


class ImuLimitRow(Base):
    """What a parameter of an IMU model may be, in the unit of files; an import replaces all of a model's."""

    __tablename__ = "imu_limits"
    __table_args__ = (UniqueConstraint("model", "parameter"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    model: Mapped[str]
    parameter: Mapped[str]
    low: Mapped[float | None]
    high: Mapped[float | None]
    unit: Mapped[str]
    guard_band: Mapped[float]


class CampaignRow(Base):
    """A campaign folder; ``manifest_sha256`` is the head of the hash chain over its accepted steps.

    ``effects_sha256`` has the hashes of the effect/1 files it began with, blanks between them; None: not known.
    """

    __tablename__ = "campaigns"
    id: Mapped[int] = mapped_column(primary_key=True)
    folder: Mapped[str] = mapped_column(unique=True)
    imu_id: Mapped[int] = mapped_column(ForeignKey("imus.id"), index=True)
    cube_id: Mapped[str | None] = mapped_column(ForeignKey("cubes.id"))
    slab_id: Mapped[str | None] = mapped_column(ForeignKey("slabs.id"))
    site_id: Mapped[str | None] = mapped_column(ForeignKey("sites.id"))
    started_utc: Mapped[datetime]
    state: Mapped[str]
    manifest_sha256: Mapped[str] = mapped_column(SHA256)
    effects_sha256: Mapped[str | None] = mapped_column(Text)
    imu: Mapped[ImuRow] = relationship()
    steps: Mapped[list["StepRow"]] = relationship(order_by="StepRow.id")


class StepRow(Base):
    """An accepted step of a campaign and the hash of its file; ``superseded`` once it was done again."""

    __tablename__ = "steps"
    id: Mapped[int] = mapped_column(primary_key=True)
    campaign_id: Mapped[int] = mapped_column(ForeignKey("campaigns.id"), index=True)
    name: Mapped[str]
    file: Mapped[str]
    sha256: Mapped[str] = mapped_column(SHA256)
    accepted_utc: Mapped[datetime]
    superseded: Mapped[bool] = mapped_column(default=False)


class CalibrationRow(ChainedRow, Base):
    """An accepted calibration: ``document`` is calibration/1 as text, ``sha256`` its hash."""

    __tablename__ = "calibrations"
    id: Mapped[int] = mapped_column(primary_key=True)
    imu_id: Mapped[int] = mapped_column(ForeignKey("imus.id"), index=True)
    campaign_id: Mapped[int | None] = mapped_column(ForeignKey("campaigns.id"))
    accepted_utc: Mapped[datetime]
    code_version: Mapped[str]
    inputs: Mapped[dict[str, str]]
    document: Mapped[str] = mapped_column(Text)
    imu: Mapped[ImuRow] = relationship()
    campaign: Mapped[CampaignRow | None] = relationship()


class IssuedCertificateRow(ChainedRow, Base):
    """A certificate as it was handed out: ``html`` is all of it, ``html_sha256`` of its UTF-8 bytes.

    ``dcc`` is the same certificate as the XML of a digital calibration certificate, ``dcc_sha256`` of its bytes;
    None where it was issued without one. ``replaces`` is the number of the certificate whose place it takes, None
    for the first of a calibration.
    """

    __tablename__ = "certificates"
    id: Mapped[int] = mapped_column(primary_key=True)
    number: Mapped[str] = mapped_column(unique=True)
    replaces: Mapped[str | None]
    calibration_sha256: Mapped[str] = mapped_column(SHA256, index=True)
    issued_utc: Mapped[datetime]
    laboratory: Mapped[str]
    html: Mapped[str] = mapped_column(Text)
    html_sha256: Mapped[str] = mapped_column(SHA256, unique=True)
    dcc: Mapped[str | None] = mapped_column(Text)
    dcc_sha256: Mapped[str | None] = mapped_column(SHA256)


class SignedFileRow(ChainedRow, Base):
    """A signed file of a certificate as it was handed out: the SHA-256 of its bytes and of the key's certificate.

    ``number`` is the certificate's, ``kind`` xml or pdf.
    """

    __tablename__ = "signed_files"
    id: Mapped[int] = mapped_column(primary_key=True)
    number: Mapped[str] = mapped_column(index=True)
    kind: Mapped[str]
    file_sha256: Mapped[str] = mapped_column(SHA256, unique=True)
    key_sha256: Mapped[str] = mapped_column(SHA256)
    signed_utc: Mapped[datetime]


class EffectEventRow(ChainedRow, Base):
    """What became of an effect of one's own: ``event`` add or withdraw, for a model or, with ``serial``, one unit.

    ``definition`` is the text of the effect/1, empty of a withdrawal, ``effect_sha256`` its hash.
    """

    __tablename__ = "effect_events"
    id: Mapped[int] = mapped_column(primary_key=True)
    event: Mapped[str]
    name: Mapped[str]
    model: Mapped[str]
    serial: Mapped[str | None]
    effect_sha256: Mapped[str] = mapped_column(SHA256, index=True)
    definition: Mapped[str] = mapped_column(Text)
    recorded_utc: Mapped[datetime]


class JournalRow(ChainedRow, Base):
    """What became of a row of any other table, written with it: ``event`` carry, insert, update or delete.

    ``content`` has the row's columns as `fixtures_db.journal` writes them, empty of a deletion. The numbers
    ``id`` are without a gap.
    """

    __tablename__ = "journal"
    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    table_name: Mapped[str]
    row_key: Mapped[str]
    event: Mapped[str]
    content: Mapped[str] = mapped_column(Text)
    recorded_utc: Mapped[datetime]
