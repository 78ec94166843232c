"""The tables of ``campaign.toml`` (`campaign/1`): names with units, types, ranges, defaults."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from procedures.arrays import FloatArray
from procedures.attitude.filter_choice import LIVE_FILTERS, MAX_LIVE_FILTERS
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import NAMES
from procedures.frames import AXES
from procedures.positions import ATTITUDES, POSITIONS, face_of
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, outputs_per_unit
from station.files.toml_file import Key, Name, PlaceTable, Sha256, Text, TomlTable, matching, read_folder_toml

CAMPAIGN_TOML = "campaign.toml"


def _rotation(axes: str) -> str:
    if axes not in ATTITUDES:
        raise ValueError(f"axes where the cube's x, y, z point, one of {', '.join(ATTITUDES)}")
    return axes


Axis = Literal["x", "y", "z"]
Face = Literal["x_up", "x_down", "y_up", "y_down", "z_up", "z_down"]
Position = Annotated[int, Field(ge=1, le=len(POSITIONS))]
# deg, 1 sigma: no autocollimator resolves 0.0036 arcsec, and what nobody can state makes equations singular
Sigma = Annotated[float, Field(ge=1e-6, le=90)]
Tilt = Annotated[float, Field(ge=-0.1, le=0.1)]
Pair = Annotated[list[Tilt], Field(min_length=2, max_length=2)]
Row = Annotated[list[float], Field(min_length=2, max_length=2)]
CubeAttitude = Annotated[str, AfterValidator(_rotation)]
SignedAxis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]


def _right_handed(imu_axes: list[SignedAxis]) -> list[SignedAxis]:
    if abs(np.linalg.det(axes_matrix(imu_axes)) - 1) > 0.5:
        raise ValueError("imu_axes to be right-handed, each cube axis once")
    return imu_axes


ImuAxes = Annotated[list[SignedAxis], Field(min_length=3, max_length=3), AfterValidator(_right_handed)]


def axes_matrix(imu_axes: Sequence[str]) -> FloatArray:
    """Return C_sb (3, 3), the cube's axes to the IMU's: row q is the cube axis along which IMU axis q points."""
    rows = np.zeros((3, 3))
    for row, name in enumerate(imu_axes):
        rows[row, AXES.index(name[1])] = 1.0 if name[0] == "+" else -1.0
    return rows


def _gyro_unit(unit: str) -> str:
    outputs_per_unit(unit, GYRO_UNITS)
    return unit


def _accel_unit(unit: str) -> str:
    outputs_per_unit(unit, ACCEL_UNITS)
    return unit


class CampaignImuTable(TomlTable):
    """``[imu]``. ``unit_gyro``, ``unit_accel``: what the outputs are nominally in, as `output_units` spells it."""

    model: Name
    serial: Name
    sample_period_s: Annotated[float, Field(ge=1e-6, le=1e6)]
    output: Literal["increments", "cumulative", "rate"]
    wrap_bits: Literal[16, 24, 32] | None = None
    unit_gyro: Annotated[str, AfterValidator(_gyro_unit)] | None = None
    unit_accel: Annotated[str, AfterValidator(_accel_unit)] | None = None

    @property
    def nominal_scale(self) -> dict[str, float]:
        """Outputs in 1 deg/s and 1 g, of the triads whose unit is stated."""
        known = (("gyroscope", self.unit_gyro, GYRO_UNITS), ("accelerometer", self.unit_accel, ACCEL_UNITS))
        scales = {triad: outputs_per_unit(unit, units) for triad, unit, units in known if unit is not None}
        return {triad: scale for triad, scale in scales.items() if scale is not None}

    @model_validator(mode="after")
    def _wraps_only_if_cumulative(self) -> Self:
        if self.wrap_bits is not None and self.output != "cumulative":
            raise ValueError('wrap_bits only with output = "cumulative"')
        if (self.unit_gyro or self.unit_accel) and self.output != "rate":
            raise ValueError('unit_gyro and unit_accel only with output = "rate"')
        return self


GRAVITY_STD, NORMAL_GRAVITY_STD = 1e-5, 5e-4  # m/s2, 1 sigma where none is given: of a survey, of the formula


class SiteTable(PlaceTable):
    """``[site]``."""

    gravity_std_m_s2: Annotated[float, Field(ge=1e-10, le=1)] | None = None
    magnetic_enu_ut: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None

    @property
    def gravity_std(self) -> float:
        """1 sigma of gravity [m/s2], that of a survey or of normal gravity where none is given."""
        return self.gravity_std_m_s2 or (NORMAL_GRAVITY_STD if self.gravity_m_s2 is None else GRAVITY_STD)


class ProcedureTable(TomlTable):
    """``[procedure]``, 1 sigma. ``seat_std_arcsec``: of a face on the slab, between placements; for moves.

    ``closure_widened_from_deg``: what was stated before turns did not close to it.
    """

    heading_std_deg: Sigma = 0.1
    closure_std_deg: Sigma = 0.02
    closure_widened_from_deg: Sigma | None = None
    seat_std_arcsec: Annotated[float, Field(ge=1e-4, le=600)] = 1.0
    unsettled_gyro_deg_h: Annotated[float, Field(ge=0, le=1e4)] | None = None
    unsettled_accelerometer_g: Annotated[float, Field(ge=0, le=1)] | None = None


class FaceTable(TomlTable):
    """``[[fixture.face]]``: the certificate of one resting face."""

    resting: Face
    up_tilt_rad: Pair
    std_rad: Annotated[float, Field(ge=1e-9, le=0.1)] | None = None
    covariance_rad2: Annotated[list[Row], Field(min_length=2, max_length=2)] | None = None

    @model_validator(mode="after")
    def _has_one_uncertainty(self) -> Self:
        if (self.std_rad is None) == (self.covariance_rad2 is None):
            raise ValueError("exactly one of std_rad and covariance_rad2")
        if self.covariance_rad2 is not None:
            (a, b), (c, d) = self.covariance_rad2
            if abs(b - c) > 1e-6 * max(abs(b), abs(c)) or a <= 0 or d <= 0 or a * d <= b * c:
                raise ValueError("covariance_rad2 to be symmetric and positive definite")
        return self


class MeasuredTable(TomlTable):
    """``[fixture.measured]``: the cube as IMUs measured it; ``units`` are their models and serial numbers."""

    names: Annotated[list[str], Field(min_length=1)]
    value_rad: list[Tilt]
    covariance_rad2: list[list[float]]
    units: list[Text] = []
    source: Text | None = None

    @model_validator(mode="after")
    def _is_a_measurement(self) -> Self:
        n = len(self.names)
        if unknown := [name for name in self.names if name not in NAMES]:
            raise ValueError(f"names of {', '.join(NAMES)}, not {unknown[0]!r}")
        if len(set(self.names)) != n or len(self.value_rad) != n:
            raise ValueError("each name once, and a value_rad for each")
        if [len(row) for row in self.covariance_rad2] != [n] * n:
            raise ValueError(f"covariance_rad2 of {n} rows and columns, as there are names")
        C = np.array(self.covariance_rad2)
        if not np.allclose(C, C.T, rtol=1e-6, atol=0) or not np.linalg.eigvalsh(C)[0] > 0:
            raise ValueError("covariance_rad2 to be symmetric and positive definite")
        return self


def measured_table(measured: MeasuredCube) -> MeasuredTable:
    """Return ``[fixture.measured]``."""
    value, covariance = measured.value.tolist(), measured.covariance.tolist()
    return MeasuredTable(
        names=list(measured.names), value_rad=value, covariance_rad2=covariance, units=list(measured.units)
    )


class FixtureTable(TomlTable):
    """``[fixture]``."""

    id: Name | None = None
    side_mm: Annotated[float, Field(ge=1, le=1e5)] | None = None
    imu_axes: ImuAxes = ["+x", "+y", "+z"]
    face: list[FaceTable] = []
    measured: MeasuredTable | None = None

    @model_validator(mode="after")
    def _is_a_cube(self) -> Self:
        faces = [face.resting for face in self.face]
        if len(set(faces)) != len(faces):
            raise ValueError("one certificate per resting face")
        if faces and self.measured is not None:
            raise ValueError("[[fixture.face]] or [fixture.measured], not both: a certificate of the faces wins")
        return self


class _Step(TomlTable):
    """``turn_on``: for which time, from 1, the unit was switched on in this campaign."""

    turn_on: Annotated[int, Field(ge=1, le=99)] | None = None


class _Attitude(_Step):
    position: Position | None = None
    axes: CubeAttitude | None = None
    up: Face | None = None
    attitude: Literal["free"] | None = None
    file: str

    @model_validator(mode="after")
    def _has_one_attitude(self) -> Self:
        if sum(value is not None for value in (self.position, self.axes, self.up, self.attitude)) != 1:
            raise ValueError("exactly one of position, axes, up and attitude")
        return self

    @property
    def number(self) -> int | None:
        """Return which of the 24 attitudes along the slab's marks it is, from 1; None of others."""
        return self.position if self.axes is None else ATTITUDES.index(self.axes) + 1


def attitude(position: int) -> dict[str, object]:
    """Return how a table names position 1..24: the twelve by their number, the others by ``axes``."""
    return {"position": position} if position <= len(POSITIONS) else {"axes": ATTITUDES[position - 1]}


class DwellTable(_Attitude):
    """``[[dwell]]``: at rest. ``kept_seat_rad``: the operator kept a seat that was judged to be off by so much."""

    kept_seat_rad: Pair | None = None


class SoakTable(_Attitude):
    """``[[soak]]``: at rest while temperature or an auxiliary channel moves."""


class TurnTable(_Step):
    """``[[turn]]``: about the vertical, whole revolutions back to where it began, or by an angle that is known."""

    axis: Axis
    direction: Literal["+", "-"]
    revolutions: Annotated[int, Field(ge=1, le=10000)] | None = None
    angle_deg: Annotated[float, Field(ge=1.0, le=3.6e6)] | None = None
    start_position: Position | None = None
    file: str

    @property
    def turned(self) -> float:
        """Revolutions, also of an angle."""
        return self.revolutions if self.revolutions is not None else (self.angle_deg or 0.0) / 360.0

    @model_validator(mode="after")
    def _turns_by_one_angle(self) -> Self:
        if (self.revolutions is None) == (self.angle_deg is None):
            raise ValueError("either revolutions or angle_deg")
        return self

    @model_validator(mode="after")
    def _starts_with_its_axis_up(self) -> Self:
        if self.start_position is not None and face_of(self.start_position) != f"{self.axis}_up":
            raise ValueError(f"a start_position with {self.axis} up")
        return self


FilterName = Annotated[str, matching("|".join(LIVE_FILTERS), f"one of {', '.join(LIVE_FILTERS)}")]
FilterNames = Annotated[list[FilterName], Field(min_length=1, max_length=MAX_LIVE_FILTERS)]


class MonitorTable(_Step):
    """``[[monitor]]``: at rest, read by attitude filters, in axes that lie north, east, down in ``position``.

    One number a filter: mean over the second half, rms about it. ``calibration`` says which one read it, or why
    none did; then there are no numbers.
    """

    position: Position
    laws: FilterNames
    file: str
    calibration: str = ""
    roll_deg: list[float] = []
    pitch_deg: list[float] = []
    scatter_deg: list[float] = []
    difference_deg: float | None = None
    level_deg: float | None = None
    drift_deg_h: float | None = None
    g_error_mg: float | None = None

    @model_validator(mode="after")
    def _has_a_number_a_filter(self) -> Self:
        if {len(each) for each in (self.roll_deg, self.pitch_deg, self.scatter_deg)} - {0, len(self.laws)}:
            raise ValueError("roll_deg, pitch_deg and scatter_deg with a number for each of laws, or none")
        return self


class MoveTable(TomlTable):
    """``[[move]]``: carried by hand from the end of one step to the beginning of another, named by their files."""

    before: Annotated[str, Field(alias="from")]
    after: Annotated[str, Field(alias="to")]
    file: str

    @property
    def turn_on(self) -> None:
        """That of its steps."""


class SequenceTable(TomlTable):
    """``[[sequence]]``: rests in unknown attitudes and moves between them."""

    file: str


class TurntableTable(TomlTable):
    """``[[rate]]``: a turntable's points."""

    axis: Axis
    file: str


class EffectsTable(TomlTable):
    """``[effects]``: the `effect/1` files, inside the folder, that it is solved with; hashes where stated."""

    files: list[str]
    sha256: list[Sha256] = []

    @model_validator(mode="after")
    def _has_a_hash_a_file(self) -> Self:
        if self.sha256 and len(self.sha256) != len(self.files):
            raise ValueError("sha256 with a hash for each of files, or none")
        return self


class CampaignTable(TomlTable):
    """The whole of ``campaign.toml``."""

    format: Literal["campaign/1"]
    imu: CampaignImuTable
    site: SiteTable | None = None
    procedure: ProcedureTable = ProcedureTable()
    fixture: FixtureTable = FixtureTable()
    effects: EffectsTable | None = None
    dwell: list[DwellTable] = []
    turn: list[TurnTable] = []
    move: list[MoveTable] = []
    sequence: list[SequenceTable] = []
    rate: list[TurntableTable] = []
    soak: list[SoakTable] = []
    monitor: list[MonitorTable] = []

    def effect_files(self) -> list[str]:
        """Return the names of the `effect/1` files that the folder is solved with."""
        return [] if self.effects is None else self.effects.files

    def steps(self) -> list["StepTable"]:
        """Return the steps of all kinds, kind by kind."""
        return [*self.dwell, *self.turn, *self.move, *self.sequence, *self.rate, *self.soak, *self.monitor]


StepTable = DwellTable | TurnTable | MoveTable | SequenceTable | TurntableTable | SoakTable | MonitorTable


def read_campaign_toml(folder: Path) -> tuple[CampaignTable, dict[Key, int], bytes]:
    """Return a folder's ``campaign.toml`` as `read_folder_toml` does."""
    return read_folder_toml(folder, CAMPAIGN_TOML, CampaignTable)
