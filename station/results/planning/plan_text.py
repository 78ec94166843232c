"""A planned campaign as people read it."""

from typing import Any

from procedures.units import ARCSEC_PER_RAD, UG_PER_G
from station.results.parameters_by_name import title_of
from station.results.planning.plan_json import given_up, not_met
from station.text import significant, table_lines

SHOWN = {"g": (UG_PER_G, "ug"), "1": (ARCSEC_PER_RAD, "arcsec")}
DIGITS = 3


def plan_text(document: dict[str, Any]) -> str:
    """Return a summary of a `planned/1` document: minutes, steps, sigmas, what is out of reach."""
    dwells = [step for step in document["steps"] if step["kind"] == "dwell"]
    turns = len(document["steps"]) - len(dwells)
    lines = [
        f"{document['minutes']:.1f} min: {len(dwells)} placements, "
        f"{f'{turns} rotations' if turns else 'no rotations'}; the usual plan takes "
        f"{document['usual_minutes']:.1f} min",
        *[f"not reachable: {_missed(row)}" for row in not_met(document)],
        *[f"less accurate in return: {_lost(row)}" for row in given_up(document)],
        "",
        *_steps(document["steps"]),
        "",
        *table_lines([_row(row) for row in document["sigmas"]], "<>>><", ("u of", "target", "plan", "usual", "")),
        "",
        *table_lines([_effect(row) for row in document["effects"]], "<<<", ("diagnosis of", "plan", "usual")),
        "",
        f"noise: {document['noise']['source']}",
        f"hands: {document['hands_s']['source']}",
    ]
    return "\n".join(lines)


def _steps(steps: list[dict[str, Any]]) -> list[str]:
    rows = []
    for number, step in enumerate(steps, 1):
        up = step.get("up", "").replace("_", " ")
        rows.append((str(number), step.get("axes") or step["name"], up, f"{step['seconds']:.0f} s"))
    return table_lines(rows, "><<>", ("", "x y z point", "", "for"))


def _row(row: dict[str, Any]) -> tuple[str, ...]:
    times, unit = SHOWN.get(row["unit"], (1.0, row["unit"]))
    numbers = [significant(times * row[key], DIGITS) if key in row else "-" for key in ("wanted", "plan", "usual")]
    return (title_of(row["parameter"]), *numbers, unit)


def _effect(row: dict[str, Any]) -> tuple[str, ...]:
    return row["effect"], *(_told(row.get(key)) for key in ("plan", "usual"))


def _told(told: dict[str, Any] | None) -> str:
    if told is None or not told["is_told"]:
        return "no"
    return f"yes, or {', or '.join(told['not_apart'])}" if told["not_apart"] else "yes"


def _missed(row: dict[str, Any]) -> str:
    name, wanted, plan, _, unit = _row(row)
    return f"{name} {wanted} {unit}; best possible {plan if plan != '-' else 'nothing'} {unit}"


def _lost(row: dict[str, Any]) -> str:
    name, _, plan, usual, unit = _row(row)
    return f"{name} {plan if plan != '-' else 'open'} {unit}, usually {usual}"
