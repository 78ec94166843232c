"""population/1 as lines of at most 80 columns for the terminal."""

from collections.abc import Iterator
from typing import Any

from procedures.history.population import MIN_UNITS, MIN_UNITS_IN_BOTH
from station.results.parameters_by_name import shown_scale, title_of
from station.text import decimals, table_lines

MAX_ROWS_SHOWN = 12  # of those that do not stand out none is shown; of those that do, so many of each kind


def population_text(document: dict[str, Any]) -> str:
    """Return what stands out, then the middle and scatter of every parameter."""
    head = f"{document['model']}, units: {document['units']}, turn-ons: {document['turn_ons']}"
    lines = [head, *(f"  left out: {text}" for text in document["left_out"]), ""]
    lines += _units(document)
    lines += _groups(document)
    rows = [_parameter(name, one) for name, one in document["parameters"].items()]
    lines += ["", "over the units' newest calibrations", *table_lines(rows, "<>><", ("", "median", "spread", ""))]
    lines += [
        "",
        f"Without any real deviation, something is flagged in {100 * document['false_alarm']:g} % of cases at "
        "most.",
    ]
    return "\n".join(lines)


def _units(document: dict[str, Any]) -> Iterator[str]:
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


def _groups(document: dict[str, Any]) -> Iterator[str]:
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


def _parameter(name: str, one: dict[str, Any]) -> tuple[str, str, str, str]:
    scale, unit = shown_scale(name, one["unit"])
    spread = one.get("spread", 0.0) * scale
    places = min(max(decimals(spread or one["units"][0]["std"] * scale), 0), 7)
    return title_of(name), f"{one['median'] * scale:.{places}f}", f"{spread:.{places}f}" if spread else "-", unit
