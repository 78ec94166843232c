"""``--as``: what a log is a recording of, as the table of a step."""

import re
from collections.abc import Sequence

from station.files.campaign_folder.campaign_schema import (
    DwellTable,
    SequenceTable,
    SoakTable,
    StepTable,
    TurnTable,
    TurntableTable,
)

EXPECTED = (
    "soak, sequence, means, dwell:N (1 to 12), dwell:FACE (x_up ... z_down), turn:+x, turn:+x:REVOLUTIONS, "
    "turn:+x:ANGLEdeg, or beside --reference rate:x or rate:-x"
)
FACES_NAMED = re.compile(r"[xyz]_(?:up|down)")
TABLE_NAMED = re.compile(r"-?[xyz]")
TURN_NAMED = re.compile(r"([+-])([xyz])(?::([0-9]{1,7}(?:\.[0-9]{1,9})?)(deg)?)?")
MIN_ANGLE_DEG, MAX_REVOLUTIONS = 1.0, 9999.0  # deg: less tells a scale factor to no percent


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
            expected = "one of rate:x, rate:-x, rate:y and so on" if has_reference else "--reference COL beside it"
            found = f"{kind!a} {'beside' if has_reference else 'without'} --reference"
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
