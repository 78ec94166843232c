"""A campaign folder read into memory."""

import hashlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from procedures.campaign.campaign import (
    Campaign,
    DwellRecord,
    FaceCertificate,
    Fixture,
    MeasuredCube,
    MoveRecord,
    ProcedureSigma,
    RateTable,
    RestRecord,
    SequenceRecord,
    Site,
    SoakRecord,
    TurnRecord,
)
from procedures.geodesy import normal_gravity
from procedures.positions import TURN_START
from procedures.units import RAD_PER_ARCSEC, RAD_S_PER_DEG_H, STANDARD_GRAVITY
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import (
    CAMPAIGN_TOML,
    CampaignImuTable,
    CampaignTable,
    DwellTable,
    FixtureTable,
    MeasuredTable,
    MoveTable,
    ProcedureTable,
    SequenceTable,
    SiteTable,
    SoakTable,
    StepTable,
    TurnTable,
    TurntableTable,
    axes_matrix,
    read_campaign_toml,
)
from station.files.campaign_folder.loaded_campaign import (
    LoadedCampaign,
    LoadedStep,
    check_for_solve,
    check_one_unit,
    clock_warnings,
    folder_effects,
)
from station.files.campaign_folder.sample_series import refuse_time_backwards, step_data
from station.files.campaign_folder.step_consistency import refuse_loose_moves, refuse_overlap, with_one_period
from station.files.opening import open_inside
from station.files.tables.strict_csv import TRIADS, SampleColumns, read_csv
from station.files.tables.table import Table
from station.files.toml_file import Key, line_of

# m/s2; within it gravity at the ground is normal almost everywhere on Earth (EGM2008)
MAX_GRAVITY_ANOMALY_M_S2 = 5e-3
# Of a site that nobody stated: gravity anywhere on the ground (9.764 to 9.834 m/s2), and the whole Earth's rate
ANY_LATITUDE, ANY_GRAVITY_STD, ANY_EARTH_RATE_DEG_H = float(np.radians(45.0)), 0.02, 15.0
_STEP_KINDS = ("dwell", "turn", "move", "sequence", "rate", "soak", "monitor")


def read_campaign(folder: Path, *, moves: bool = True) -> LoadedCampaign:
    """Read a ``campaign/1`` folder; every file it names is read and checked; moves only if ``moves``.

    Raise `DataRefused` if the folder breaks a rule of docs/how-to/campaign-folder.md: with file, line, found and
    expected.
    """
    tables, lines, content = read_campaign_toml(folder)
    files = {CAMPAIGN_TOML: hashlib.sha256(content).hexdigest()}
    steps = list[LoadedStep]()
    for kind in (kind for kind in _STEP_KINDS if moves or kind != "move"):
        for index, table in enumerate(getattr(tables, kind)):
            line = line_of((kind, index, "file"), lines)
            step, files[table.file] = _read_step(folder, kind, table, line, tables.imu)
            steps.append(step)
    if not steps:
        raise DataRefused(folder / CAMPAIGN_TOML, None, "no step", f"at least one of {', '.join(_STEP_KINDS)}")
    effects = folder_effects(folder, tables.effects, lines)
    files |= {name: effect.sha256 for name, effect in effects.items()}
    return replace(loaded_campaign(folder, tables, steps, files, lines), effects=tuple(effects.values()))


def loaded_campaign(
    folder: Path, tables: CampaignTable, steps: list[LoadedStep], files: Mapping[str, str],
    lines: dict[Key, int] | None = None,
) -> LoadedCampaign:  # fmt: skip
    """Put the steps of a campaign together, wherever they were read from; ``files`` has each file's sha256.

    ``lines`` has the line of each key of ``campaign.toml``, where there is one. Raise `DataRefused` if two steps
    overlap in time.
    """
    refuse_loose_moves(folder, steps, lines)
    warnings = [
        *refuse_overlap(folder, steps),
        *_doubts(tables),
        *(w for step in steps if step.data for w in step.data.warnings),
    ]
    steps, period_std, text = with_one_period(steps)
    warnings += text
    used = [step for step in steps if isinstance(step.table, DwellTable | TurnTable | MoveTable | SequenceTable)]
    campaign = replace(
        _campaign(tables, used),
        rate_tables=tuple(
            _rate_table(step, step.table) for step in steps if isinstance(step.table, TurntableTable)
        ),
        soaks=tuple(
            SoakRecord(step.table.file, step.table.number or 0, step.table.up, step.data.series)
            for step in steps
            if isinstance(step.table, SoakTable) and step.data is not None
        ),
        period_std=period_std,
    )
    warnings += clock_warnings(tables, campaign)
    unused = tuple(step.label for step in steps if step not in used)
    return LoadedCampaign(folder, tables, campaign, tuple(steps), files, tuple(warnings), unused)


def _read_step(
    folder: Path, kind: str, table: StepTable, line: int, imu: CampaignImuTable
) -> tuple[LoadedStep, str]:
    columns = _read_table(folder, table, line, imu)
    return loaded_step(kind, table, columns, imu), columns.sha256


def loaded_step(kind: str, table: StepTable, columns: Table, imu: CampaignImuTable) -> LoadedStep:
    """Return a step with the columns of its file; raises as `step_data`."""
    if isinstance(table, TurntableTable):
        if "t_s" in columns.columns:
            refuse_time_backwards(columns, np.diff(columns.columns["t_s"]))
        return LoadedStep(kind, table, None, columns.columns, columns.lines)
    return LoadedStep(kind, table, step_data(columns, imu))


def _read_table(folder: Path, table: StepTable, line: int, imu: CampaignImuTable) -> Table:
    file = folder / table.file
    suffix = Path(table.file).suffix
    if suffix not in {".csv", ".mcap"} or (suffix == ".mcap" and isinstance(table, TurntableTable)):
        wanted = "a .csv file" if isinstance(table, TurntableTable) else "a .csv or .mcap file"
        raise DataRefused(folder / CAMPAIGN_TOML, line, f"file = {ascii(table.file)[:80]}", wanted)
    with open_inside(folder, table.file, folder / CAMPAIGN_TOML, line) as stream:
        if suffix == ".csv":
            kind = SampleColumns(counts=imu.output != "rate", rate_table=isinstance(table, TurntableTable))
            return read_csv(stream, file, kind)
        from station.files.mcap_files import read_table  # heavy: only where a folder has MCAP files

        return read_table(stream, file, counts=imu.output != "rate")


def _rate_table(step: LoadedStep, table: TurntableTable) -> RateTable:
    reference = step.points["rate_ref_deg_s"]
    absent = np.full(len(reference), np.nan)
    output = np.stack([step.points.get(name, absent) for name in TRIADS["gyro"]], axis=1)
    return RateTable(
        table.file, table.axis, reference, output, step.points.get("temp_c", absent), step.points.get("t_s"),
        step.lines,
    )  # fmt: skip


def _campaign(tables: CampaignTable, used: list[LoadedStep]) -> Campaign:
    dwells, turns, moves = list[DwellRecord](), list[TurnRecord](), list[MoveRecord]()
    rests, sequences = list[RestRecord](), list[SequenceRecord]()
    for step in used:
        assert step.data is not None
        match step.table:
            case DwellTable(file=file, number=int(position)) as dwell:
                dwells.append(DwellRecord(file, position, step.data.series, dwell.turn_on or 1))
            case DwellTable(file=file, up=up):
                rests.append(RestRecord(file, up, step.data.series))
            case MoveTable(file=file) as move:
                moves.append(MoveRecord(file, move.before, move.after, step.data.series))
            case SequenceTable(file=file):
                sequences.append(SequenceRecord(file, step.data.series))
            case TurnTable(file=file, axis=axis, direction=direction) as turn:
                start = turn.start_position or TURN_START[axis]
                on = turn.turn_on or 1
                turns.append(TurnRecord(file, axis, direction, turn.turned, start, step.data.series, on))
    return Campaign(
        tables.imu.model,
        tables.imu.serial,
        tables.imu.output != "rate",
        site_of(tables.site),
        tuple(dwells),
        tuple(turns),
        _sigma(tables.procedure, is_site_known=tables.site is not None),
        _fixture(tables.fixture),
        tuple(rests),
        tuple(sequences),
        tables.imu.sample_period_s,
        nominal_scale=tables.imu.nominal_scale,
        moves=tuple(moves),
    )


def _sigma(procedure: ProcedureTable, is_site_known: bool) -> ProcedureSigma:
    unsettled = procedure.unsettled_gyro_deg_h or 0.0
    if not is_site_known:  # along a sensor the Earth's rate is another at every attitude, as an unsettled bias is
        unsettled = float(np.hypot(unsettled, ANY_EARTH_RATE_DEG_H))
    return ProcedureSigma(
        float(np.radians(procedure.heading_std_deg)),
        float(np.radians(procedure.closure_std_deg)),
        unsettled * RAD_S_PER_DEG_H,
        (procedure.unsettled_accelerometer_g or 0.0) * STANDARD_GRAVITY,
        procedure.seat_std_arcsec * RAD_PER_ARCSEC,
    )


def site_of(site: SiteTable | None) -> Site:
    """Return the site of a campaign, any on Earth where none is given."""
    if site is None:
        return Site(ANY_LATITUDE, STANDARD_GRAVITY, ANY_GRAVITY_STD)
    latitude = float(np.radians(site.latitude_deg))
    gravity = site.gravity_m_s2 if site.gravity_m_s2 is not None else normal_gravity(latitude, site.height_m)
    field = site.magnetic_enu_ut
    return Site(latitude, gravity, site.gravity_std, None if field is None else (field[0], field[1], field[2]))


def _fixture(fixture: FixtureTable) -> Fixture:
    faces: dict[str, FaceCertificate] = {
        face.resting: FaceCertificate(
            np.array(face.up_tilt_rad, dtype=float),
            np.eye(2) * face.std_rad**2
            if face.std_rad is not None
            else np.array(face.covariance_rad2, dtype=float),
        )
        for face in fixture.face
    }
    return Fixture(faces, axes_matrix(fixture.imu_axes), fixture.id, _measured(fixture.measured))


def _measured(table: MeasuredTable | None) -> MeasuredCube | None:
    if table is None:
        return None
    value, covariance = np.array(table.value_rad), np.array(table.covariance_rad2)
    return MeasuredCube(tuple(table.names), value, covariance, tuple(table.units))


NO_SITE = f"{CAMPAIGN_TOML}: no [site]"


def assumed_of_site(triads: Collection[str]) -> str:
    """Return what is assumed of an unknown site, as far as it matters to triads."""
    assumed = {
        "accel": f"gravity is assumed to be {STANDARD_GRAVITY} +- {ANY_GRAVITY_STD} m/s2",
        "gyro": f"the Earth's rate is unknown (u = {ANY_EARTH_RATE_DEG_H:g} deg/h)",
    }
    return ", and ".join(text for triad, text in assumed.items() if triad in triads)


def _doubts(tables: CampaignTable) -> Iterator[str]:
    """Yield what the tables themselves give reason to warn of."""
    measured, unit = tables.fixture.measured, f"{tables.imu.model} {tables.imu.serial}"
    if measured is not None and unit in measured.units:
        yield (
            f"{CAMPAIGN_TOML}: fixture.measured comes from campaigns of {unit} itself; its K2 affects both, so "
            f"the two agree better than their accuracy"
        )
    for dwell in tables.dwell:
        if dwell.kept_seat_rad is not None:
            yield (
                f"{dwell.file}: kept although the cube was tilted by "
                f"{np.degrees(np.linalg.norm(dwell.kept_seat_rad)):.2g} deg; "
                f"record position {dwell.axes or dwell.position} again"
            )
    procedure, site = tables.procedure, tables.site
    if procedure.closure_widened_from_deg is not None:
        yield (
            f"{CAMPAIGN_TOML}: closure_std_deg was increased by the operator from "
            f"{procedure.closure_widened_from_deg:.3g} to {procedure.closure_std_deg:.3g}, "
            "because manual rotations did not meet it"
        )
    if site is None:
        yield f"{NO_SITE}: {assumed_of_site(TRIADS)}"
        return
    normal = normal_gravity(float(np.radians(site.latitude_deg)), site.height_m)
    stated = normal if site.gravity_m_s2 is None else site.gravity_m_s2
    off = stated - normal
    if abs(off) > MAX_GRAVITY_ANOMALY_M_S2:  # gravity of another place than the stated latitude and height
        yield (
            f"{CAMPAIGN_TOML}: gravity_m_s2 = {stated:.9g} is {off:+.2g} m/s2 away from the {normal:.4f} of "
            f"latitude {site.latitude_deg:.6g} deg and height {site.height_m:.6g} m, "
            f"expected within {MAX_GRAVITY_ANOMALY_M_S2:g}: if it is wrong, "
            f"the error of the accelerometers' scale factors is {-1e6 * off / stated:+.0f} ppm; "
            f"check gravity, latitude and height"
        )


def read_for_solve(folders: Sequence[Path], *, moves: bool = True) -> list[LoadedCampaign]:
    """Read folders that are to be solved jointly, with their ``moves`` or without; refuse what no solve may use.

    Raises
    ------
    DataRefused
        A folder breaks a rule, is of another unit, or its sample period is more than 1 % off.
    """
    loaded = [read_campaign(folder, moves=moves) for folder in folders]
    check_one_unit(loaded)
    for one in loaded:
        if one.tables.site is None:
            remedy = "add it, or run `station diagnose`"
            raise DataRefused(one.folder / CAMPAIGN_TOML, None, "no [site]", "[site] with latitude_deg", remedy)
        check_for_solve(one)
    return loaded
