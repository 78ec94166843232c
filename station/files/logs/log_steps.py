"""A log as a step: of the stated kind, else by its motion and rests, or by the reference of a rate table."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.counts.encoder_angle import slope_and_correlation
from procedures.errors import ErrorCode
from procedures.frames import AXES
from procedures.free_positions.rest_detection import (
    MAX_SCALE_ERROR,
    MIN_SOAK_REST_S,
    moves_and_rests,
    true_angle,
    turned_deg,
    turning,
    whole_turns,
)
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import loaded_step
from station.files.campaign_folder.campaign_schema import (
    CampaignImuTable,
    DwellTable,
    SequenceTable,
    SoakTable,
    StepTable,
    TurnTable,
    TurntableTable,
)
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.logs.inferred_reference import MIN_CORRELATION
from station.files.logs.log_columns import LogColumns
from station.files.tables.strict_csv import TRIADS
from station.files.tables.table import Table
from station.text import plural

EXPECTED = (
    "soak, sequence, means, dwell:N (1 to 12), dwell:FACE (x_up ... z_down), turn:+x, turn:+x:REVOLUTIONS, "
    "turn:+x:ANGLEdeg, or with --reference rate:x or rate:-x"
)
FACES_NAMED = re.compile(r"[xyz]_(?:up|down)")
TABLE_NAMED = re.compile(r"-?[xyz]")
TURN_NAMED = re.compile(r"([+-])([xyz])(?::([0-9]{1,7}(?:\.[0-9]{1,9})?)(deg)?)?")
MIN_ANGLE_DEG, MAX_REVOLUTIONS = 1.0, 9999.0  # deg: less does not determine a scale factor to a percent


def turned_revolutions(kind: str) -> float | None:
    """Return the revolutions that ``turn:+z:0.5`` or ``turn:+z:180deg`` states; None where it states none."""
    found = TURN_NAMED.fullmatch(kind.partition(":")[2])
    if found is None or found[3] is None:
        return None
    return float(found[3]) / (360.0 if found[4] else 1.0)


def _is_turn(kind: str) -> bool:
    stated = turned_revolutions(kind)
    is_named = TURN_NAMED.fullmatch(kind.partition(":")[2]) is not None
    return is_named and (stated is None or MIN_ANGLE_DEG / 360 <= stated <= MAX_REVOLUTIONS)


def check_kind(kind: str) -> None:
    """Raise `ValueError` where ``kind`` is none; says what is expected."""
    what, _, rest = kind.partition(":")
    known = {
        "soak": rest == "",
        "sequence": rest == "",
        "means": rest == "",
        "dwell": bool(re.fullmatch(r"[1-9]|1[0-2]", rest) or FACES_NAMED.fullmatch(rest)),
        "turn": _is_turn(kind),
        "rate": bool(TABLE_NAMED.fullmatch(rest)),
    }
    if not known.get(what, False):
        raise ValueError(f"found {kind!a}, expected {EXPECTED}")


def check_kinds(kinds: Sequence[str], logs: int, has_reference: bool) -> None:
    """Raise `ValueError` where ``kinds`` of as many ``logs`` are none, too many, or not what a reference says."""
    for kind in kinds:
        check_kind(kind)
        if kind.startswith("rate:") != has_reference:
            expected = "one of rate:x, rate:-x, rate:y and so on" if has_reference else "--reference COL with it"
            found = f"{kind!a} {'with' if has_reference else 'without'} --reference"
            raise ValueError(f"found {found}, expected {expected}")
    if len(kinds) > 1 and len(kinds) != logs:
        raise ValueError(f"found {len(kinds)} kinds for {logs} logs, expected one, or one a log")


def step_table(kind: str, file: str, revolutions: float = 1.0) -> tuple[str, StepTable]:
    """Return the kind of a step and its table; ``revolutions`` of a turn that does not say."""
    what, _, rest = kind.partition(":")
    if what == "dwell":
        is_face = FACES_NAMED.fullmatch(rest)
        where = {"up": rest} if is_face else {"position": int(rest)}
        return what, DwellTable.model_validate({"file": file, **where})
    if what == "turn" and (found := TURN_NAMED.fullmatch(rest)):
        turned = turned_revolutions(kind) or revolutions
        by = {"angle_deg": 360.0 * turned} if turned % 1 else {"revolutions": round(turned)}
        if found[4] and turned % 1:
            by = {"angle_deg": float(found[3])}
        return what, TurnTable.model_validate({"file": file, "axis": found[2], "direction": found[1], **by})
    if what == "sequence":
        return what, SequenceTable(file=file)
    if what == "rate":
        return what, TurntableTable.model_validate({"file": file, "axis": rest[-1]})
    return "soak", SoakTable(file=file, attitude="free")


REFERENCE = "rate_ref_deg_s"
UNCALIBRATED = 0.03  # of 1: scale factor errors in data sheets of MEMS gyroscopes
END_DEG = 2.0  # by which a bias that changes and noise move the angle by a gyroscope
READ_DEG = 0.1  # to which a reference is read at an end


def step_of_log(
    columns: Table, kind: str | None, imu: CampaignImuTable, found: LogColumns,
    ends: tuple[float, bool] | None = None,
) -> tuple[LoadedStep, Table, list[str]]:  # fmt: skip
    """Return a log's step, the columns of its file, and what was guessed of it as text.

    ``ends`` is by how much a reference angle grew that was read at both ends alone, as `angle_at_ends` has it.
    Raise `DataRefused` if no gyroscope follows the reference of a rate table, and nobody stated which it turned;
    if the angle of a turn is unknown.
    """
    if ends is not None:
        step, guesses = _turned_by(columns, kind, imu, *ends)
        return step, columns, guesses
    if found.reference is not None:
        return _on_table(columns, kind, imu, found)
    if kind is None:
        return _guessed(columns, imu)
    step, guesses = _at_bench(columns, kind, imu)
    return step, columns, guesses


def refuse_restless(campaign: Campaign) -> None:
    """Refuse a guessed soak that turns and never rests: there is no noise and no drift at rest in it.

    Raises
    ------
    DataRefused
        Naming the first such log.
    """
    for soak in campaign.soaks:
        turned = turning(soak.series, campaign.nominal_scale.get("gyroscope"))
        if turned is not None and turned.rest is None:
            fast = f"by up to {turned.fastest:.3g} deg/s about {AXES[turned.axis]}"
            raise DataRefused(
                soak.name, None, f"turns, {fast}, and no rest of {MIN_SOAK_REST_S:g} s", "a log that rests",
                "state what it is: --as turn:+z, or --reference COL of a rate table",
            )  # fmt: skip


def _guessed(columns: Table, imu: CampaignImuTable) -> tuple[LoadedStep, Table, list[str]]:
    """Return a log of unstated kind: a sequence, or a soak, which of a log that turns is the part at rest."""
    step = loaded_step(*step_table("soak", columns.name), columns, imu)
    assert step.data is not None
    series = step.data.series
    if moves_and_rests(series, imu.nominal_scale.get("accelerometer")):
        step = LoadedStep("sequence", SequenceTable(file=columns.name), step.data)
        return step, columns, [f"{columns.name}: moves and rests, treated as a sequence"]
    turned = turning(series, imu.nominal_scale.get("gyroscope"))
    if turned is None:
        return step, columns, [f"{columns.name}: treated as a soak, at rest at an unknown attitude"]
    axis = AXES[turned.axis]
    fast = f"by up to {turned.fastest:.3g} deg/s about {axis}"
    say = f"state --as turn:{'+' if turned.sign > 0 else '-'}{axis}, or --reference COL of a rate table"
    if turned.rest is None:
        return step, columns, [f"{columns.name}: it turns, {fast}: treated as a soak; {say}"]
    columns = columns.rows_at(np.arange(columns.rows)[turned.rest])
    step = loaded_step(*step_table("soak", columns.name), columns, imu)
    rest = series.t[turned.rest]
    only = f"only the {len(rest) * series.period:.0f} s at rest from {rest[0]:.1f} s on are used, as a soak"
    return step, columns, [f"{columns.name}: it turns, {fast}: {only}; {say}"]


def _at_bench(columns: Table, kind: str, imu: CampaignImuTable) -> tuple[LoadedStep, list[str]]:
    name, table = step_table(kind, columns.name)
    step = loaded_step(name, table, columns, imu)
    data = step.data
    assert data is not None
    if name == "turn" and kind.count(":") == 1:
        scale = imu.nominal_scale.get("gyroscope")
        turned = turned_deg(data.series, AXES.index(kind[-1]), scale) if scale else None
        revolutions = None if turned is None else whole_turns(turned)
        if turned is None or revolutions is None:
            raise _angle_unknown(columns.name, kind, turned)
        step = LoadedStep(*step_table(kind, columns.name, revolutions), data)
        whole = f"treated as exactly {plural(revolutions, 'revolution')}, {360 * revolutions} deg"
        by = f"the gyroscope turned by {abs(turned):.6g} deg (state {kind}:ANGLEdeg if it differs)"
        return step, [f"{columns.name}: {whole}: {by}"]
    return step, []


def _turned_by(
    columns: Table, kind: str | None, imu: CampaignImuTable, angle: float, wraps: bool
) -> tuple[LoadedStep, list[str]]:
    """Return a turn by an angle [deg] read at both ends; where it ``wraps`` the gyroscope has the whole turns."""
    step = loaded_step(*step_table("soak", columns.name), columns, imu)
    assert step.data is not None
    series, scale = step.data.series, imu.nominal_scale.get("gyroscope")
    along = (kind or "rate:x").removeprefix("rate:")
    axis, sign = AXES.index(along[-1]), -1 if along.startswith("-") else 1
    if kind is None and series.gyro is not None:
        axis = int(np.argmax([abs(turned_deg(series, i, 1.0)) for i in range(3)]))
    guesses = [f"{columns.name}: the reference angle is read only at both ends: it increased by {angle:.6g} deg"]
    angle *= sign
    if wraps and not scale:
        raise _angle_unknown(columns.name, f"turn:{'+' if angle > 0 else '-'}{AXES[axis]}", None)
    if scale and series.gyro is not None:
        read, turned = angle, turned_deg(series, axis, scale)
        angle, is_reversed = _agreed(
            columns.name, AXES[axis], read, turned, wraps=wraps, is_stated=kind is not None
        )
        if is_reversed:
            guesses.append(
                f"{columns.name}: the reference counts in the opposite direction to gyroscope {AXES[axis]}"
            )
        if more := round(abs(angle - (-read if is_reversed else read)) / 360):
            guesses.append(f"{columns.name}: {plural(more, 'whole turn')} more, by the gyroscope")
    if abs(angle) < MIN_ANGLE_DEG:
        raise DataRefused(
            columns.name, None, f"an angle that increased by {angle:.3g} deg", f"at least {MIN_ANGLE_DEG:g} deg",
            "name another column as --reference", code=ErrorCode.TURN_ANGLE,
        )  # fmt: skip
    stated = f"turn:{'+' if angle > 0 else '-'}{AXES[axis]}:{abs(angle):.9f}deg"
    guesses.append(f"{columns.name}: treated as {stated} (state --as rate:{AXES[axis]} for another axis)")
    return LoadedStep(*step_table(stated, columns.name), step.data), guesses


def _agreed(
    file: str, axis: str, read: float, turned: float, *, wraps: bool, is_stated: bool
) -> tuple[float, bool]:
    """Return by which angle [deg] a log turned, and whether its reference counts the other way than the gyroscope.

    ``read`` is by how much the reference grew, but for whole turns where it ``wraps``; ``turned`` is what the
    gyroscope says. A direction that ``is_stated`` stays. Raise `DataRefused` if no angle agrees with both, or more
    than one does.
    """
    if wraps:
        along, against = (true_angle(turned, each, UNCALIBRATED, END_DEG) for each in (read, -read))
    else:
        is_opposite = turned * read < 0 and abs(turned) > END_DEG
        along = None if is_opposite else read
        against = -read if is_opposite and abs(turned + read) < max(UNCALIBRATED * abs(read), END_DEG) else None
    is_near = against is None or (
        along is not None and (abs(along - against) < READ_DEG or abs(along - turned) <= abs(against - turned))
    )
    if along is not None and (is_stated or is_near):
        return along, False
    if along is None and against is not None and not is_stated:
        return against, True
    sign = "+" if turned > 0 else "-"
    other = (
        f"--as rate:{axis} or rate:-{axis} by the direction in which the reference counts, or " if against else ""
    )
    raise DataRefused(
        file, None, f"a reference of {read:.6g} deg and a gyroscope {axis} of {turned:.6g} deg",
        f"a single angle that agrees with both within {100 * UNCALIBRATED:g} %",
        f"state {other}--as turn:{sign}{axis}:ANGLEdeg without --reference", ErrorCode.TURN_ANGLE,
    )  # fmt: skip


def _angle_unknown(file: str, kind: str, turned: float | None) -> DataRefused:
    """Return the question by how much a turn was: the gyroscope that is to be calibrated cannot answer it."""
    found = (
        "a rotation by an unstated angle, and a gyroscope of unknown unit"
        if turned is None
        else f"a turn by {abs(turned):.6g} deg, by the gyroscope itself"
    )
    whole = max(round(abs(turned or 0.0) / 360), 1)
    remedy = (
        f"state {kind}:{whole} if it was {plural(whole, 'whole revolution')}, else its true angle as "
        f"{kind}:ANGLEdeg"
    )
    expected = (
        f"a single number of whole revolutions within {100 * MAX_SCALE_ERROR:g} %, or an angle that is stated"
    )
    return DataRefused(file, None, found, expected, remedy, code=ErrorCode.TURN_ANGLE)


def _on_table(
    columns: Table, kind: str | None, imu: CampaignImuTable, found: LogColumns
) -> tuple[LoadedStep, Table, list[str]]:
    guesses = list[str]()
    if kind is None:
        kind, guess = _guessed_axis(columns.columns, found)
        guesses.append(f"{columns.name}: {guess}")
    axis = kind.removeprefix("rate:")
    if axis.startswith("-"):
        turned = {**columns.columns, REFERENCE: -columns.columns[REFERENCE]}
        columns = replace(columns, columns=turned)
    return loaded_step(*step_table(kind, columns.name), columns, imu), columns, guesses


def _guessed_axis(columns: Mapping[str, FloatArray], found: LogColumns) -> tuple[str, str]:
    """Return the kind of step by the gyroscope that the reference turns most, and how that was found."""
    reference = columns[REFERENCE]
    outputs = [columns.get(name) for name in TRIADS["gyro"]]
    slopes = [(0.0, 0.0) if each is None else slope_and_correlation(reference, each) for each in outputs]
    follows = [correlation if slope else 0.0 for slope, correlation in slopes]
    followers = [i for i in range(3) if abs(follows[i]) >= MIN_CORRELATION]
    if not followers:
        best = max(range(3), key=lambda i: abs(follows[i]))
        raise DataRefused(
            found.table.file, None,
            f"no gyroscope that follows {found.reference} (best {AXES[best]}, correlation {follows[best]:.2f})",
            "the one that the table turned", f"name it: --as rate:z{_if_taken_for_a_rate(found)}",
        )  # fmt: skip
    turned = max(followers, key=lambda i: abs(slopes[i][0]))
    axis = f"{'-' if follows[turned] < 0 else ''}{AXES[turned]}"
    guess = f"the table turned about {axis}, correlation {follows[turned]:.4f} (state --as rate:{axis})"
    return f"rate:{axis}", guess


def _if_taken_for_a_rate(found: LogColumns) -> str:
    if found.degrees_per_angle is not None:
        return ""
    return f"; {found.reference} is treated as a rate: name it *_deg if it is an angle"
