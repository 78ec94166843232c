"""history/1 as lines of at most 80 columns for the terminal."""

from collections.abc import Iterator
from itertools import groupby
from textwrap import wrap
from typing import Any

from station.results.parameters_by_name import (
    Parameter,
    ParameterShift,
    largest,
    shown,
    shown_scale,
    shown_sigma,
    title_of,
)
from station.results.verdict import verdict_in_words
from station.text import WIDTH, decimals, table_lines

SIGNIFICANT_P = 0.05  # a drift's p-value, adjusted for the number of parameters
MAX_ALARM_DATES = 10  # dates shown
LISTED_PARAMETERS = ("scale_factor", "bias")  # shown in the list; the file holds misalignment too


def history_text(document: dict[str, Any]) -> str:
    """Return the calibrations one by one, then what they say together, model by model."""
    lines = [line for entry in document["calibrations"] for line in _entry(entry)]
    for one in document["analysis"]:
        lines += ["", *_analysis(one)]
    return "\n".join(lines)


def _entry(entry: dict[str, Any]) -> Iterator[str]:
    verdict = verdict_in_words(entry.get("verdict", "not judged"), has_limits=entry["limited"] > 0)
    when = entry["accepted_utc"][:16].replace("T", " ")
    yield f"{when} UTC  {entry['model']}  {verdict}, {entry['status']}  {entry['sha256'][:12]}"
    for name, sha256 in entry.get("effects", {}).items():
        yield f"  with {name}{f' (effect/1, sha256 {sha256[:12]})' if sha256 else ''}"
    found = {name: Parameter(name, **values) for name, values in entry["parameters"].items()}
    moved = {
        name: ParameterShift(found[name], one["shift"], one["shift_sigma"]) for name, one in entry["drift"].items()
    }
    for name, one in found.items():
        if name.split(".")[1] in LISTED_PARAMETERS:
            value, unit = shown(one)
            drift = f"  {moved[name].sigmas:+z.1f} u" if name in moved else ""
            yield f"  {one.title:<28}{value:>13} +- {shown_sigma(one)} {unit}{drift}"
    if (most := largest(moved)) is not None:
        many = sum(one["p_adjusted"] < SIGNIFICANT_P for one in entry["drift"].values())
        yield f"  largest change: {most.parameter.title}, {most}"
        yield f"  significant changes (p < {SIGNIFICANT_P:g}, Holm): {many} of {len(moved)}"


def _analysis(one: dict[str, Any]) -> Iterator[str]:
    span = f"{one['first_utc'][:10]} to {one['last_utc'][:10]}"
    yield f"{one['model']}, turn-ons: {one['turn_ons']}, {span}"
    if any("prediction" in track for track in one["parameters"].values()):
        yield f"  predicted for {one['predicted_utc'][:10]}: {one['predicted_because']}"
    yield f"  control limit {one['control_limit']:.2f} on z and on its moving average, A: above it"
    yield from (f"  not used: {text}" for text in one["left_out"])
    for _, group in groupby(one["parameters"].items(), lambda item: item[0].rpartition(".")[0]):
        tracks = dict(group)
        yield f"  {_title(*next(iter(tracks.items())))}"
        rows = (_cells(name, track) for name, track in tracks.items())
        yield from table_lines(
            rows, "<>>><<>", ("", "newest", "turn-on", "last z", "", "predicted, 95 %", "outside")
        )
    needs = {text for track in one["parameters"].values() for text in track["needs"]}
    for text in sorted(needs):
        word, _, wording = text.partition(": ")
        yield from wrap(
            f"the history is too short to predict: {wording}" if word == "prediction" else f"too few for {text}",
            width=WIDTH, initial_indent="  ", subsequent_indent="    ",
        )  # fmt: skip
    yield from _alarms(one)
    yield from _touches(one)


def _title(name: str, track: dict[str, Any]) -> str:
    ends = track.get("limits", {})
    scale, unit = shown_scale(name, track["unit"])
    limits = " to ".join(f"{ends[end] * scale:g}" if end in ends else "open" for end in ("low", "high"))
    text = f"; limits {limits}" if ends else ""
    return f"{name.rpartition('.')[0].replace('_', ' ').replace('.', ' ')} [{unit}]{text}"


def _cells(name: str, track: dict[str, Any]) -> tuple[str, ...]:
    parameter = Parameter(name, track["value"][-1], track["std"][-1], track["unit"])
    scatter, chart, ahead = (track.get(key) for key in ("repeatability", "chart", "prediction"))
    mark = "A" if chart and track["calibrations"][-1] in chart["alarms"] else ""
    predicted = " to ".join(_number(name, track, end) for end in ahead["interval_95"]) if ahead else ""
    outside = f"{100 * ahead['probability_outside']:.1f}%" if ahead and "probability_outside" in ahead else ""
    return (
        name.rpartition(".")[2],
        shown(parameter)[0],
        _scatter(name, track, scatter) if scatter else "-",
        f"{chart['z'][-1]:+z.1f}" if chart else "-",
        mark,
        predicted,
        outside,
    )


def _alarms(one: dict[str, Any]) -> Iterator[str]:
    on = dict[str, list[str]]()
    for name, track in one["parameters"].items():
        for when, sha256 in zip(track["measured_utc"], track["calibrations"], strict=True):
            if sha256 in track.get("chart", {}).get("alarms", ()):
                on.setdefault(when[:10], []).append(title_of(name))
    if len(on) > MAX_ALARM_DATES:
        yield f"  {len(on) - MAX_ALARM_DATES} earlier dates with alarms; --json lists all"
    for when in sorted(on)[-MAX_ALARM_DATES:]:
        more = f" and {len(on[when]) - 1} more" if len(on[when]) > 1 else ""
        yield f"  alarm on {when}: {on[when][0]}{more}"


def _touches(one: dict[str, Any]) -> Iterator[str]:
    dates = {
        name: track["prediction"]["interval_reaches_limit_utc"][:10]
        for name, track in one["parameters"].items()
        if "interval_reaches_limit_utc" in track.get("prediction", {})
    }
    if dates:
        first = min(dates, key=lambda name: dates[name])
        yield f"  the 95 % interval first reaches a limit on {dates[first]}: {title_of(first)}"


def _number(name: str, track: dict[str, Any], value: float) -> str:
    """Return a value of a parameter's kind with the decimals that its prediction, else its sigma, deserves."""
    ends = track.get("prediction", {}).get("interval_95")
    std = track["std"][-1] if ends is None else max((ends[1] - ends[0]) / 4, track["std"][-1])
    return shown(Parameter(name, value, std, track["unit"]))[0]


def _scatter(name: str, track: dict[str, Any], found: dict[str, Any]) -> str:
    """Return the repeatability with two digits; where none was seen, what it may be at most (95 %)."""
    value = found["std"] or found["interval_95"][1]
    if not value:  # they agree better than their own sigmas let expect
        return "0"
    number = value * shown_scale(name, track["unit"])[0]
    return ("" if found["std"] else "<") + f"{number:.{min(max(decimals(number), 0), 7)}f}"
