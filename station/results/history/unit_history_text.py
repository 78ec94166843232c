"""A unit's history as lines of at most 80 columns for the terminal."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import attrgetter, itemgetter
from textwrap import wrap

from station.results.history.unit_history import ModelHistory, ParameterHistory, StoredCalibration, UnitHistory
from station.results.parameters_by_name import (
    ParameterShift,
    largest,
    shown,
    shown_scale,
    shown_sigma,
    title_of,
)
from station.results.verdict import verdict_in_words
from station.text import WIDTH, table_lines

SIGNIFICANT_P = 0.05  # a drift's p-value, adjusted for the number of parameters
MAX_ALARM_DATES = 10  # dates shown
LISTED_PARAMETERS = ("scale_factor", "bias")  # shown in the list; the file holds misalignment too


def history_text(history: UnitHistory) -> str:
    """Return the calibrations one by one, then what they say together, model by model."""
    lines = [line for entry in history.calibrations for line in _entry(entry)]
    for one in history.analysis:
        lines += ["", *_analysis(one)]
    return "\n".join(lines)


def _entry(entry: StoredCalibration) -> Iterator[str]:
    verdict = verdict_in_words(entry.verdict or "not judged", has_limits=entry.limited > 0)
    yield f"{entry.accepted} UTC  {entry.model}  {verdict}, {entry.status}  {entry.sha256[:12]}"
    for name, sha256 in (entry.effects or {}).items():
        yield f"  with {name}{f' (effect/1, sha256 {sha256[:12]})' if sha256 else ''}"
    for name, one in entry.parameters.items():
        if name.split(".")[1] in LISTED_PARAMETERS:
            value, unit = shown(one)
            change = f"  {entry.drift[name].shift_sigma:+z.1f} u" if name in entry.drift else ""
            yield f"  {one.title:<28}{value:>13} +- {shown_sigma(one)} {unit}{change}"
    moved = {
        name: ParameterShift(entry.parameters[name], one.shift, one.shift_sigma)
        for name, one in entry.drift.items()
    }
    if (most := largest(moved)) is not None:
        many = sum(one.p_adjusted < SIGNIFICANT_P for one in entry.drift.values())
        yield f"  largest change: {most.parameter.title}, {most}"
        yield f"  significant changes (p < {SIGNIFICANT_P:g}, Holm): {many} of {len(moved)}"


def _analysis(one: ModelHistory) -> Iterator[str]:
    tracks = list(one.parameters.values())
    yield f"{one.model}, turn-ons: {one.turn_ons}, {one.first_utc[:10]} to {one.last_utc[:10]}"
    if any(track.prediction for track in tracks):
        yield f"  predicted for {one.predicted_utc[:10]}: {one.predicted_because}"
    yield f"  control limit {one.control_limit:.2f} on z and on its moving average, A: above it"
    yield from (f"  not used: {text}" for text in one.left_out)
    for kind, group in groupby(tracks, attrgetter("kind")):
        alike = list(group)
        yield f"  {title_of(kind)} {_unit_and_limits(alike[0])}"
        header = ("", "newest", "turn-on", "last z", "", "predicted, 95 %", "outside")
        yield from table_lines(map(_cells, alike), "<>>><<>", header)
    for text in sorted({text for track in tracks for text in track.needs}):
        word, _, wording = text.partition(": ")
        yield from wrap(
            f"the history is too short to predict: {wording}" if word == "prediction" else f"too few for {text}",
            width=WIDTH, initial_indent="  ", subsequent_indent="    ",
        )  # fmt: skip
    yield from _alarms(tracks)
    yield from _touches(tracks)


def _unit_and_limits(track: ParameterHistory) -> str:
    scale, unit = shown_scale(track.name, track.unit)
    if track.limits is None:
        return f"[{unit}]"
    ends = (f"{track.limits[end] * scale:g}" if end in track.limits else "open" for end in ("low", "high"))
    return f"[{unit}]; limits {' to '.join(ends)}"


def _cells(track: ParameterHistory) -> tuple[str, ...]:
    chart, ahead = track.chart, track.prediction
    outside = None if ahead is None else ahead.probability_outside
    return (
        track.axis,
        shown(track.at(track.value[-1], track.std[-1]))[0],
        _scatter(track),
        f"{chart.z[-1]:+z.1f}" if chart else "-",
        "A" if chart and track.calibrations[-1] in chart.alarms else "",
        _predicted(track, *ahead.interval_95) if ahead else "",
        "" if outside is None else f"{100 * outside:.1f}%",
    )


def _alarms(tracks: Sequence[ParameterHistory]) -> Iterator[str]:
    on = dict[str, list[str]]()
    for track in tracks:
        for when, sha256 in zip(track.measured_utc, track.calibrations, strict=True):
            if track.chart and sha256 in track.chart.alarms:
                on.setdefault(when[:10], []).append(title_of(track.name))
    if len(on) > MAX_ALARM_DATES:
        yield f"  {len(on) - MAX_ALARM_DATES} earlier dates with alarms; --json lists all"
    for when in sorted(on)[-MAX_ALARM_DATES:]:
        more = f" and {len(on[when]) - 1} more" if len(on[when]) > 1 else ""
        yield f"  alarm on {when}: {on[when][0]}{more}"


def _touches(tracks: Sequence[ParameterHistory]) -> Iterator[str]:
    dates = [
        (touch[:10], title_of(track.name))
        for track in tracks
        if track.prediction and (touch := track.prediction.interval_reaches_limit_utc)
    ]
    if dates:
        when, title = min(dates, key=itemgetter(0))
        yield f"  the 95 % interval first reaches a limit on {when}: {title}"


def _predicted(track: ParameterHistory, low: float, high: float) -> str:
    """Return an interval with the decimals that it, else the newest sigma, deserves."""
    std = max((high - low) / 4, track.std[-1])
    return " to ".join(shown(track.at(end, std))[0] for end in (low, high))


def _scatter(track: ParameterHistory) -> str:
    """Return the repeatability with two digits; where none was seen, what it may be at most (95 %)."""
    if (found := track.repeatability) is None:
        return "-"
    if not (value := found.std or found.interval_95[1]):  # they agree better than their own sigmas let expect
        return "0"
    return ("" if found.std else "<") + shown_sigma(track.at(0.0, value))
