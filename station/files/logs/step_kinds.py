"""``--as``: what a log is a recording of, as the table of a step."""

import re

from procedures.frames import AXES
from station.files.campaign_folder.campaign_schema import (
    DwellTable,
    SequenceTable,
    SoakTable,
    StepTable,
    TurnTable,
    TurntableTable,
)

EXPECTED = "soak, sequence, dwell:N (1 to 12), dwell:FACE (x_up ... z_down), turn:+x or turn:+x:REVOLUTIONS"
FACES_NAMED = re.compile(r"[xyz]_(?:up|down)")
TURN_NAMED = re.compile(r"([+-])([xyz])(?::([1-9][0-9]{0,3}))?")


def check_kind(kind: str) -> None:
    """Raise `ValueError` where ``kind`` is none; says what is expected."""
    what, _, rest = kind.partition(":")
    known = {
        "soak": rest == "",
        "sequence": rest == "",
        "dwell": bool(re.fullmatch(r"[1-9]|1[0-2]", rest) or FACES_NAMED.fullmatch(rest)),
        "turn": bool(TURN_NAMED.fullmatch(rest)),
    }
    if not known.get(what, False):
        raise ValueError(f"found {kind!a}, expected {EXPECTED}")


def step_table(kind: str, file: str, revolutions: int = 1) -> tuple[str, StepTable]:
    """Return the kind of a step and its table; ``revolutions`` of a turn that does not say."""
    what, _, rest = kind.partition(":")
    if what == "dwell":
        is_face = FACES_NAMED.fullmatch(rest)
        where = {"up": rest} if is_face else {"position": int(rest)}
        return what, DwellTable.model_validate({"file": file, **where})
    if what == "turn" and (found := TURN_NAMED.fullmatch(rest)):
        turned = {"axis": found[2], "direction": found[1], "revolutions": int(found[3] or revolutions)}
        return what, TurnTable.model_validate({"file": file, **turned})
    if what == "sequence":
        return what, SequenceTable(file=file)
    if what == "rate":
        return what, TurntableTable.model_validate({"file": file, "axis": rest or AXES[2]})
    return "soak", SoakTable(file=file, attitude="free")
