"""population/1: units of a model that stand out, and fixtures, sites or operators that shift a parameter.

Two families of tests, each with half of `ALPHA`: all parameters of all units (Bonferroni over parameters, with
that over units in `procedures.statistics.population`), and all parameters of all groups (Holm). The adjusted
p-values are doubled for it, so that a fleet in which nothing is off shows something with probability `ALPHA` at
most.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fixtures_db.stored_calibrations import MADE_WITH, Run, turn_ons
from procedures.statistics.population import (
    MIN_UNITS,
    MIN_UNITS_IN_BOTH,
    GroupShift,
    group_shift,
    judge_fleet,
    significant,
)
from procedures.statistics.significance import holm
from station.results.history.unit_history import RunParameter, by_parameter, values_and_sigmas
from station.results.parameters_by_name import shown_scale, title_of
from station.text import decimals, table_lines

ALPHA = 0.05
TEST_FAMILIES = 2


@dataclass(frozen=True, slots=True)
class GroupTest:
    """A test: whether this group (a cube named so) shifts this parameter."""

    kind: str
    name: str
    parameter: str


def population_document(model: str, runs: Sequence[Run]) -> dict[str, Any]:
    """Return population/1 of all runs of a model; recordings that were solved again count once."""
    distinct = turn_ons(runs)
    held, left_out = by_parameter(runs)
    groups, untold = _groups(held)
    return {
        "format": "population/1",
        "model": model,
        "units": len({run.serial for run in distinct}),
        "turn_ons": len(distinct),
        "false_alarm": ALPHA,
        "left_out": left_out,
        "parameters": {name: _parameter(one, len(held)) for name, one in held.items()},
        "groups": groups,
        "cannot_tell": untold,
    }


def _parameter(held: Sequence[RunParameter], tests: int) -> dict[str, Any]:
    newest = {run.serial: one for run, one in held}
    serials = list(newest)
    value, std = values_and_sigmas(list(newest.values()))
    found = judge_fleet(value, std)
    flagged = significant(found.extremes, ALPHA / (TEST_FAMILIES * tests))
    return {
        "unit": held[-1][1].unit,
        "median": found.median,
        **({} if found.spread is None else {"spread": found.spread}),
        "units": [
            {"serial": one, "value": v, "std": s}
            for one, v, s in zip(serials, value.tolist(), std.tolist(), strict=True)
        ],
        "extremes": [
            {"shift": one.shift, "std": one.std, "p_adjusted": min(1.0, TEST_FAMILIES * tests * one.p_adjusted),
             "serial": serials[one.unit], "stands_out": one in flagged}
            for one in found.extremes
        ],
    }  # fmt: skip


def _groups(held_of: dict[str, list[RunParameter]]) -> tuple[list[dict[str, Any]], list[str]]:
    every = dict.fromkeys(
        GroupTest(kind, run.made_with[kind], parameter)
        for kind in MADE_WITH
        for parameter, held in held_of.items()
        for run, _ in held
        if kind in run.made_with
    )
    found = {key: one for key in every if (one := _shift(held_of, key, frozenset())) is not None}
    adjusted = _without_those_off(held_of, found)
    significant = {(key.kind, key.name) for key in found}
    untold = sorted(
        {(key.kind, key.name) for key in every} - significant, key=lambda one: (MADE_WITH.index(one[0]), one[1])
    )
    rows = [_row(key, one, held_of[key.parameter][-1][1].unit, adjusted[key]) for key, one in found.items()]
    return sorted(rows, key=lambda row: float(row["p_value"])), [f"{kind} {name}" for kind, name in untold]


def _without_those_off(
    held_of: dict[str, list[RunParameter]], found: dict[GroupTest, GroupShift]
) -> dict[GroupTest, float]:
    """Return adjusted p; ``found`` is changed: groups are compared again without one that is off.

    An off cube is among "the others" of each good one, which would stand out by it, the other way.
    """
    off = dict[tuple[str, str], frozenset[str]]()  # by kind and parameter
    while True:
        adjusted = {
            key: min(1.0, TEST_FAMILIES * p) for key, p in holm({k: x.p_value for k, x in found.items()}).items()
        }
        new = [k for k, p in adjusted.items() if p <= ALPHA and k.name not in off.get((k.kind, k.parameter), ())]
        if not new:
            return adjusted
        first = min(new, key=lambda key: found[key].p_value)
        family = first.kind, first.parameter
        # ... the largest shift of its kind: of three cubes one off by 2 is at +2, each good one at -1
        worst = max(
            (key for key in new if (key.kind, key.parameter) == family), key=lambda key: abs(found[key].shift)
        )
        off[family] = off.get(family, frozenset()) | {worst.name}
        for key in found:
            is_other = (key.kind, key.parameter) == family and key.name not in off[family]
            if is_other and (again := _shift(held_of, key, off[family])) is not None:
                found[key] = again


def _shift(held_of: dict[str, list[RunParameter]], key: GroupTest, without: frozenset[str]) -> GroupShift | None:
    names = [(run.made_with.get(key.kind), run, one) for run, one in held_of[key.parameter]]
    known = [(name, run, one) for name, run, one in names if name is not None and name not in without]
    inside = np.array([name == key.name for name, _, _ in known])
    return group_shift(
        [run.serial for _, run, _ in known], inside, *values_and_sigmas([one for _, _, one in known])
    )


def _row(key: GroupTest, one: GroupShift, unit: str, p_adjusted: float) -> dict[str, Any]:
    return {
        "kind": key.kind,
        "id": key.name,
        "parameter": key.parameter,
        "unit": unit,
        "shift": one.shift,
        "std": one.std,
        "p_value": one.p_value,
        "p_adjusted": p_adjusted,
        "units": one.units,
        "stands_out": p_adjusted <= ALPHA,
    }


MAX_ROWS_SHOWN = 12  # of those that do not stand out none is shown; of those that do, so many of each kind


def population_text(document: dict[str, Any]) -> str:
    """Return what stands out, then the middle and scatter of every parameter."""
    head = f"{document['model']}, units: {document['units']}, turn-ons: {document['turn_ons']}"
    lines = [head, *(f"  left out: {text}" for text in document["left_out"]), ""]
    lines += _unit_lines(document)
    lines += _group_lines(document)
    rows = [_parameter_row(name, one) for name, one in document["parameters"].items()]
    lines += ["", "over the units' newest calibrations", *table_lines(rows, "<>><", ("", "median", "spread", ""))]
    lines += [
        "",
        f"Without any real deviation, something is flagged in {100 * document['false_alarm']:g} % of cases at "
        "most.",
    ]
    return "\n".join(lines)


def _unit_lines(document: dict[str, Any]) -> Iterator[str]:
    if document["units"] < MIN_UNITS:
        yield f"units: {document['units']} are too few to find an outlier, {MIN_UNITS} are needed"
        return
    rows = [
        (f"{one['serial']}", name, one, track["unit"])
        for name, track in document["parameters"].items()
        for one in track["extremes"]
        if one["stands_out"]
    ]
    yield from _listed("units", rows)


def _group_lines(document: dict[str, Any]) -> Iterator[str]:
    rows = [
        (f"{one['kind']} {one['id']}", one["parameter"], one, one["unit"])
        for one in document["groups"]
        if one["stands_out"]
    ]
    yield from _listed("cubes, surface plates, sites and operators", rows)
    if untold := document["cannot_tell"]:
        yield f"  not determined: {', '.join(untold)}"
        yield f"  (it takes {MIN_UNITS_IN_BOTH} units calibrated with it and without it)"


def _listed(what: str, rows: list[tuple[str, str, dict[str, Any], str]]) -> Iterator[str]:
    yield f"{what} that differ: {len(rows) or 'none'}"
    for who, name, one, unit in sorted(rows, key=lambda row: float(row[2]["p_adjusted"]))[:MAX_ROWS_SHOWN]:
        scale, shown = shown_scale(name, unit)
        std = one["std"] * scale
        places = min(max(decimals(std), 0), 7)
        by = f"{one['shift'] * scale:+.{places}f} +- {std:.{places}f} {shown}"
        yield f"  {who}: {title_of(name)}"
        yield f"      {by}, p = {one['p_adjusted']:.1g} adjusted"
    if len(rows) > MAX_ROWS_SHOWN:
        yield f"  and {len(rows) - MAX_ROWS_SHOWN} more; --json lists all"


def _parameter_row(name: str, one: dict[str, Any]) -> tuple[str, str, str, str]:
    scale, unit = shown_scale(name, one["unit"])
    spread = one.get("spread", 0.0) * scale
    places = min(max(decimals(spread or one["units"][0]["std"] * scale), 0), 7)
    return title_of(name), f"{one['median'] * scale:.{places}f}", f"{spread:.{places}f}" if spread else "-", unit
