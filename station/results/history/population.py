"""population/1: units of a model that stand out, and fixtures, sites or operators that shift a parameter.

Two families of tests, each with half of `ALPHA`: all parameters of all units (Bonferroni over parameters, with
that over units in `procedures.statistics.population`), and all parameters of all groups (Holm). The adjusted
p-values are doubled for it, so that a fleet in which nothing is off shows something with probability `ALPHA` at
most.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter

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
from station.results.parameters_by_name import Parameter, shown, shown_shift, shown_sigma
from station.text import table_lines

ALPHA = 0.05
TEST_FAMILIES = 2


@dataclass(frozen=True, slots=True)
class GroupTest:
    """A test: whether this group (a cube named so) shifts this parameter."""

    kind: str
    name: str
    parameter: str


@dataclass(frozen=True, slots=True)
class UnitValue:
    """A unit's newest value, and its sigma."""

    serial: str
    value: float
    std: float


@dataclass(frozen=True, slots=True)
class UnitDeviation:
    """How far a unit is from the others' mean, the sigma of that, its adjusted p, and whether it stands out."""

    shift: float
    std: float
    p_adjusted: float
    serial: str
    stands_out: bool


@dataclass(frozen=True, slots=True)
class PopulationParameter:
    """Middle and scatter of a parameter over the units, every value, and the units that may stand out."""

    unit: str
    median: float
    spread: float | None
    units: list[UnitValue]
    extremes: list[UnitDeviation]


@dataclass(frozen=True, slots=True)
class GroupDeviation:
    """By how much a group shifts a parameter, the sigma of that, p, and by how many units."""

    kind: str
    id: str
    parameter: str
    unit: str
    shift: float
    std: float
    p_value: float
    p_adjusted: float
    units: int
    stands_out: bool


@dataclass(frozen=True, slots=True)
class Population:
    """The units of a model; the fields of this and of what it holds are the keys of `population/1`."""

    format: str
    model: str
    units: int
    turn_ons: int
    false_alarm: float
    left_out: list[str]
    parameters: dict[str, PopulationParameter]
    groups: list[GroupDeviation]
    cannot_tell: list[str]


def population(model: str, runs: Sequence[Run]) -> Population:
    """Return the population of all runs of a model; recordings that were solved again count once."""
    distinct = turn_ons(runs)
    held, left_out = by_parameter(runs)
    groups, undetermined = _groups(held)
    return Population(
        format="population/1",
        model=model,
        units=len({run.serial for run in distinct}),
        turn_ons=len(distinct),
        false_alarm=ALPHA,
        left_out=left_out,
        parameters={name: _parameter(one, len(held)) for name, one in held.items()},
        groups=groups,
        cannot_tell=undetermined,
    )


def _parameter(held: Sequence[RunParameter], tests: int) -> PopulationParameter:
    newest = {run.serial: one for run, one in held}
    serials = list(newest)
    value, std = values_and_sigmas(list(newest.values()))
    found = judge_fleet(value, std)
    flagged = significant(found.extremes, ALPHA / (TEST_FAMILIES * tests))
    return PopulationParameter(
        held[-1][1].unit,
        found.median,
        found.spread,
        list(map(UnitValue, serials, value.tolist(), std.tolist())),
        [
            UnitDeviation(
                one.shift, one.std, min(1.0, TEST_FAMILIES * tests * one.p_adjusted), serials[one.unit],
                one in flagged,
            )
            for one in found.extremes
        ],
    )  # fmt: skip


def _groups(held_of: dict[str, list[RunParameter]]) -> tuple[list[GroupDeviation], list[str]]:
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
    undetermined = sorted(
        {(key.kind, key.name) for key in every} - significant, key=lambda one: (MADE_WITH.index(one[0]), one[1])
    )
    rows = [_row(key, one, held_of[key.parameter][-1][1].unit, adjusted[key]) for key, one in found.items()]
    return sorted(rows, key=attrgetter("p_value")), [f"{kind} {name}" for kind, name in undetermined]


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


def _row(key: GroupTest, one: GroupShift, unit: str, p_adjusted: float) -> GroupDeviation:
    return GroupDeviation(
        key.kind, key.name, key.parameter, unit, one.shift, one.std, one.p_value, p_adjusted, one.units,
        p_adjusted <= ALPHA,
    )  # fmt: skip


MAX_ROWS_SHOWN = 12  # of those that do not stand out none is shown; of those that do, so many of each kind


def population_text(found: Population) -> str:
    """Return what stands out, then the middle and scatter of every parameter."""
    rows = [_parameter_row(name, one) for name, one in found.parameters.items()]
    lines = [
        f"{found.model}, units: {found.units}, turn-ons: {found.turn_ons}",
        *(f"  left out: {text}" for text in found.left_out),
        "",
        *_unit_lines(found),
        *_group_lines(found),
        "",
        "over the units' newest calibrations",
        *table_lines(rows, "<>><", ("", "median", "spread", "")),
        "",
        f"Without any real deviation, something is flagged in {100 * found.false_alarm:g} % of cases at most.",
    ]
    return "\n".join(lines)


def _unit_lines(found: Population) -> Iterator[str]:
    if found.units < MIN_UNITS:
        yield f"units: {found.units} are too few to find an outlier, {MIN_UNITS} are needed"
        return
    rows = [
        (one.serial, Parameter(name, one.shift, one.std, track.unit), one.p_adjusted)
        for name, track in found.parameters.items()
        for one in track.extremes
        if one.stands_out
    ]
    yield from _listed("units", rows)


def _group_lines(found: Population) -> Iterator[str]:
    rows = [
        (f"{one.kind} {one.id}", Parameter(one.parameter, one.shift, one.std, one.unit), one.p_adjusted)
        for one in found.groups
        if one.stands_out
    ]
    yield from _listed("cubes, surface plates, sites and operators", rows)
    if undetermined := found.cannot_tell:
        yield f"  not determined: {', '.join(undetermined)}"
        yield f"  (it takes {MIN_UNITS_IN_BOTH} units calibrated with it and without it)"


def _listed(what: str, rows: list[tuple[str, Parameter, float]]) -> Iterator[str]:
    yield f"{what} that differ: {len(rows) or 'none'}"
    for who, shift, p_adjusted in sorted(rows, key=itemgetter(2))[:MAX_ROWS_SHOWN]:
        yield f"  {who}: {shift.title}"
        yield f"      {shown_shift(shift)}, p = {p_adjusted:.1g} adjusted"
    if len(rows) > MAX_ROWS_SHOWN:
        yield f"  and {len(rows) - MAX_ROWS_SHOWN} more; --json lists all"


def _parameter_row(name: str, one: PopulationParameter) -> tuple[str, str, str, str]:
    median = Parameter(name, one.median, one.spread or one.units[0].std, one.unit)
    value, unit = shown(median)
    return median.title, value, shown_sigma(median) if one.spread else "-", unit
