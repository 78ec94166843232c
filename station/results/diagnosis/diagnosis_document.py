"""A diagnosis as a document: everything that a reader is shown, in the order in which it is shown.

Built once from a `diagnosis/2`, which holds the numbers; `diagnosis_text` and `diagnosis_html` lay it out. Its
words are those of `diagnosis_wording` and `finding_wording`.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from procedures.effects import CATALOGUE
from procedures.frames import TRIADS
from station.results.diagnosis.diagnosis_wording import (
    OTHERS_TITLE,
    PROBABILITY_NOTE,
    alternatives,
    by_term,
    left_lines,
    not_looked_at,
    not_separable_in_words,
    other_terms,
    searched_in_words,
    unnamed_in_words,
    verdict_sentence,
    verdict_title,
    warnings_of,
)
from station.results.diagnosis.finding_wording import (
    MAX_COEFFICIENTS,
    coefficient_rows,
    confidence_in_words,
    equation_of,
    error_text,
    explained,
    importance,
    meaning_of,
    notable_sizes,
    notes,
    place_of,
    probabilities_text,
    probability_text,
    proposed_in_words,
    readings_in_words,
    shown_unit,
    where_text,
)
from station.results.diagnosis.uncalibrated import rests_and_moves_lines, turns_lines
from station.results.parameters_by_name import (
    Parameter,
    applied,
    parameters,
    shown,
    shown_scale,
    shown_sigma,
    title_of,
)
from station.results.report.noise_document import NoiseChannel, read_channel
from station.results.solution_text import effect_rows, measured

ERRORS_TITLE = "error (rms), without -> with the findings in the model"
MAX_MOVED = 8
HELD = 2e-9  # rad, u of a misalignment that is 0 by the choice of axes
MAX_OTHERS = 6
MIN_SHIFT_SIGMAS = 1.0  # u
TEXTBOOK_BIASES = ("bias_12_position", "bias_two_direction")  # their sigma is counting noise only
CAUSE_COLUMNS = ("cause", "size", "probability", "explained")
PLAN_HINT = "--plan FILE writes its steps for `station calibrate --plan FILE`"


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells below a title and a header; ``note`` explains them.

    ``align`` has ``<`` for each column that is flush left and ``>`` for each that is flush right.
    """

    title: str
    align: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def __bool__(self) -> bool:
        """Say whether there is something to show."""
        return bool(self.rows)


@dataclass(frozen=True, slots=True)
class Lines:
    """Sentences or lines of text below a title."""

    title: str
    lines: tuple[str, ...]

    def __bool__(self) -> bool:
        """Say whether there is something to show."""
        return bool(self.lines)


@dataclass(frozen=True, slots=True)
class Cause:
    """A row of the first table and what is known of it: an error term, or what acts without a name.

    ``effect`` is its name and ``place`` where it acts, by which its figure is found. ``sentences`` say how sure it
    is, ``explained`` its share of the squared held-out error. ``alternatives`` are the names that it may have
    instead, with their probabilities.
    """

    effect: str
    place: str
    title: str
    about: str
    probability: str
    size: str
    explained: str
    sentences: tuple[str, ...]
    alternatives: tuple[tuple[str, str], ...] = ()
    tables: tuple[Table, ...] = ()
    equation: str = ""
    latex: str = ""
    readings: tuple[str, ...] = ()

    @property
    def is_detailed(self) -> bool:
        """Say whether more is known of it than its row."""
        return bool(self.sentences or self.tables)

    def rows(self, number: int) -> list[tuple[str, str, str, str]]:
        """Return the cells of its row, as `CAUSE_COLUMNS`, and those of its alternatives."""
        return [
            (f"{number}. {self.title}", self.size, self.probability, self.explained),
            *((f"   or {name}", "", probability, "") for name, probability in self.alternatives),
        ]


@dataclass(frozen=True, slots=True)
class DiagnosisDocument:
    """What a diagnosis says: the first screen, then the details of each cause, then the tables behind them.

    ``verdict`` is the word of `diagnosis/2`, ``title`` the same as a title. ``noise`` are channels of `noise/1`.
    """

    verdict: str
    title: str
    headline: str
    causes: tuple[Cause, ...]
    sections: tuple[Table | Lines, ...]
    cause_note: str = ""
    not_separable: tuple[str, ...] = ()
    measure_next: str = ""
    plan_hint: str = ""
    searched: str = ""
    noise: Sequence[NoiseChannel] = ()
    not_observable: str = ""
    warnings: tuple[str, ...] = ()


def document_of(found: Mapping[str, Any]) -> DiagnosisDocument:
    """Return a `diagnosis/2` as a document."""
    is_shared = any(each.get("aliases") for each in found["findings"]) or bool(found.get("unnamed"))
    has_steps = "solution" in found and found["recording"] != "rate table"
    return DiagnosisDocument(
        verdict=found["verdict"],
        title=verdict_title(found),
        headline=verdict_sentence(found),
        causes=causes_of(found),
        cause_note=PROBABILITY_NOTE if is_shared else "",
        not_separable=tuple(not_separable_in_words(found)),
        measure_next=found["next_measurement"],
        plan_hint=PLAN_HINT if found["next_measurement"] and has_steps else "",
        searched=searched_in_words(found),
        sections=tuple(each for each in _sections(found) if each),
        noise=tuple(map(read_channel, found.get("noise", ()))),
        not_observable=", ".join(found.get("not_observable", ())),
        warnings=(*not_looked_at(found), *warnings_of(found.get("solution", found))),
    )


def causes_of(found: Mapping[str, Any]) -> tuple[Cause, ...]:
    """Return the causes, the surest and largest first, proposed ones last."""
    named = [(importance(several[0]), _named(found, several)) for several in by_term(found["findings"])]
    unnamed = [(importance(each), _unnamed(found, each)) for each in found.get("unnamed", ())]
    proposed = [cause for _, cause in named if cause.latex]
    known = [each for each in (*named, *unnamed) if each[1] not in proposed]
    return (*(cause for _, cause in sorted(known, key=lambda each: each[0])), *proposed)


def _named(found: Mapping[str, Any], several: Sequence[Mapping[str, Any]]) -> Cause:
    first, place = several[0], place_of(several)
    sentences = [confidence_in_words(first), *notes(first), *proposed_in_words(first)]
    others = alternatives(found, first)
    if others and first["separate_by"] not in found["next_measurement"]:
        sentences.append(f"to separate the alternatives: {first['separate_by']}")
    table = _coefficients(first) if len(several) == 1 else _occurrences(several)
    return Cause(
        effect=first["effect"],
        place=where_text(first["where"]),
        title=f"{first['effect']}: {meaning_of(first).lower()}" if first.get("fault") else first["effect"],
        about=", ".join(part for part in (first["kind"], place) if part),
        probability=probabilities_text(several),
        size=notable_sizes(first, 1),
        explained=explained(first),
        sentences=tuple(sentences),
        alternatives=tuple(others),
        tables=(table,),
        equation=equation_of(first),
        latex=first.get("latex", ""),
        readings=tuple(readings_in_words(first)),
    )


def _coefficients(finding: Mapping[str, Any]) -> Table:
    rows = tuple((row.name, row.value, row.size) for row in coefficient_rows(finding))
    more = len(finding["coefficients"]) - MAX_COEFFICIENTS
    note = f"and {more} more, smaller" if more > 0 else ""
    return Table("", "<<>", ("coefficient", "value +- u", "value/u"), rows, note)


def _occurrences(several: Sequence[Mapping[str, Any]]) -> Table:
    rows = [(where_text(e["where"]), probability_text(e["probability"]), notable_sizes(e, 1)) for e in several]
    return Table("", "<<<", ("where", "probability", "size"), tuple(rows))


def _unnamed(found: Mapping[str, Any], cause: Mapping[str, Any]) -> Cause:
    return Cause(
        effect="",
        place="",
        title=f"no known error term: {unnamed_in_words(cause)}",
        about="",
        probability=probability_text(cause["joint_probability"]),
        size="",
        explained="",
        sentences=(),
        alternatives=tuple(alternatives(found, cause)),
    )


def _sections(found: Mapping[str, Any]) -> Iterator[Table | Lines]:
    """Yield the tables and lines behind the verdict; some are empty."""
    solution = found.get("solution", {})
    for effect in solution.get("effects", ()):
        title, rows = effect_rows(effect)
        yield Table(f"in the model from the start: {title}", "<<", ("coefficient", "value +- u"), tuple(rows))
    if found["recording"] != "campaign":  # that of a campaign is in `station solve` and its report
        yield from _calibrations(solution)
    yield Table(
        "on the rate table; the output at rest includes the Earth's rate along its axis",
        "<<",
        ("quantity", "value +- u"),
        tuple(_on_table(solution.get("rate_tables", {"gyroscope": {}, "unit": {}}))),
    )
    yield from error_tables(found["error"])
    yield Lines("largest residuals", tuple(left_lines(found)))
    yield Table(
        "the unexplained residual increases the uncertainty: U (95 %), largest increases",
        "<>><",
        ("parameter", "U without it", "U with it", "unit"),
        tuple(_wider(found.get("widened", ()))),
    )
    yield Table(
        "parameters that changed most (change in units of u)",
        "<>><>",
        ("parameter", "before", "after +- u", "unit", "change"),
        tuple(_moved(found["parameters"])),
    )
    yield others_table(found)
    yield Lines("rests and transfers", tuple(rests_and_moves_lines(found)))
    yield Lines("rotations", tuple(turns_lines(found)))
    yield channel_table(found.get("channels", ()), found["findings"], has_noise="noise" in found)


def others_table(found: Mapping[str, Any]) -> Table:
    """Return the other error terms that were considered."""
    return Table(OTHERS_TITLE, "<<", ("error term", "probability"), tuple(other_terms(found)[:MAX_OTHERS]))


def _on_table(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what rate tables gave: name, and value with u and unit."""
    for name, sensors in found["gyroscope"].items():
        for axis, one in sensors.items():
            value = measured(one["value"], one["std"], found["unit"][name])
            yield f"gyroscope {name.replace('_', ' ')} {axis}", value


def _calibrations(solution: Mapping[str, Any]) -> Iterator[Table | Lines]:
    """Yield what was solved of each triad, and which was not."""
    known = applied(parameters(solution))
    for triad in (name for name in TRIADS if name in solution):
        rows = list[tuple[str, str]]()
        for one in known.values():
            scale, unit = shown_scale(one.name, one.unit)
            is_held = one.std is None or (one.name.split(".")[1] == "misalignment" and one.std < HELD)
            if one.name.startswith(triad) and one.std is not None and not is_held:
                words = title_of(one.name).removeprefix(f"{triad} ")
                rows.append((words, measured(one.value * scale, one.std * scale, unit)))
        yield Table(f"{triad} calibration", "<<", ("parameter", "value +- u"), tuple(rows))
    missing = [triad for triad in TRIADS if triad not in solution and solution and "rate_tables" not in solution]
    yield Lines("not solved", tuple(missing))


def error_tables(errors: Sequence[Mapping[str, Any]]) -> Iterator[Table]:
    """Yield the errors without and with the findings, a table for each way by which rows were held out."""
    for method in dict.fromkeys(each["method"] for each in errors):
        rows = list[tuple[str, ...]]()
        for error in (each for each in errors if each["method"] == method):
            (in_data, unit), (held, _) = error_text(error, ""), error_text(error)
            rows.append((error["quantity"], unit, in_data, held))
        title = "validation data" if method.startswith("validation") else "held out"
        header = ("quantity", "unit", "in the data", title)
        note = (
            method if method.startswith("validation") else f"held out: {method.removesuffix(', held out in turn')}"
        )
        yield Table(ERRORS_TITLE, "<<>>", header, tuple(rows), note)


def _wider(widened: Iterable[Mapping[str, Any]]) -> Iterator[tuple[str, ...]]:
    """Yield the parameters whose expanded uncertainty what is left widens most: name, without, with it, unit."""
    for one in widened:
        factor, unit = shown_unit(one["unit"])
        yield (
            title_of(one["name"]),
            *(f"{one[key] * factor:.3g}" for key in ("expanded_without", "expanded")),
            unit,
        )


def _moved(parameters: Iterable[Mapping[str, Any]]) -> Iterator[tuple[str, ...]]:
    """Yield title, before, after with u, unit and shift in u of those that moved most."""
    notable = [
        p
        for p in parameters
        if abs(p["shift_sigma"]) >= MIN_SHIFT_SIGMAS and p["name"].split(".")[1] not in TEXTBOOK_BIASES
    ]
    for row in sorted(notable, key=lambda row: -abs(row["shift_sigma"]))[:MAX_MOVED]:
        one = Parameter(row["name"], row["after"], row["std"], row["unit"])
        after, unit = shown(one)
        before, _ = shown(one, row["before"])
        yield title_of(one.name), before, f"{after} +- {shown_sigma(one)}", unit, _sigmas(row["shift_sigma"])


def _sigmas(shift: float) -> str:
    return f"{shift:+.1f}" if abs(shift) < 999.5 else f"{shift:+.0f}" if abs(shift) < 99999 else f"{shift:+.0e}"


CHANNEL_COLUMNS = {
    "scale_factor": "scale factor", "drift": "drift", "by_temperature": "by temperature",
    "random_walk": "random walk", "bias_instability": "bias instability",
}  # fmt: skip
NOISE_COLUMNS = ("random_walk", "bias_instability")
STILL_IN = " (the causes above are still in it)"
CONFOUNDED = "the temperature went with the time: drift and temperature cannot be separated"
NOT_KNOWN = "unknown random walk: the recording is too short, or the counts are too coarse"


def channel_table(
    channels: Sequence[Mapping[str, Any]], findings: Sequence[Mapping[str, Any]] = (), *, has_noise: bool = False
) -> Table:
    """Return what single channels show, each fitted by itself; their noise unless it stands elsewhere.

    Where a finding separates time and temperature, it is not contradicted.
    """
    keys = [key for key in CHANNEL_COLUMNS if any(key in each for each in channels)]
    keys = [key for key in keys if not (has_noise and key in NOISE_COLUMNS)]
    recordings = list(dict.fromkeys(f"{each['seconds']:.0f} s of {each['recording']}" for each in channels))
    is_one = len(recordings) == 1
    rows = [
        (
            each["channel"] if is_one else f"{each['channel']}, {each['seconds']:.0f} s of {each['recording']}",
            *(_channel_cell(each.get(key)) for key in keys),
        )
        for each in channels
    ]
    named = [
        CATALOGUE[f["effect"]] for f in findings if f["confidence"] != "possible" and f["effect"] in CATALOGUE
    ]
    separating = [each for each in named if each.driver in {"temperature", "time"} and not each.is_scatter]
    separated = {each.name.partition(".")[0] for each in separating}
    open_ones = [each for each in channels if each["channel"].partition(" ")[0] not in separated]
    remarks = [CONFOUNDED] if any(each.get("is_confounded") for each in open_ones) else []
    remarks += [NOT_KNOWN] if not has_noise and any("random_walk" not in each for each in channels) else []
    of = f", {recordings[0]}" if is_one else ""
    title = f"each channel by itself, as recorded{STILL_IN if findings else ''}{of}"
    header = ("channel", *(CHANNEL_COLUMNS[key] for key in keys))
    return Table(title, "<" * len(header), header, tuple(rows), "; ".join(remarks))


def _channel_cell(value: Mapping[str, Any] | None) -> str:
    if value is None:
        return ""
    if "std" in value:
        return measured(value["value"], value["std"], value["unit"])
    return f"{value['value']:.3g} {value['unit']}"
