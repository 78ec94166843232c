"""A `noise/1` as text to read in 80 columns."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from station.results.diagnosis.diagnosis_wording import p_text
from station.results.solution_text import measured
from station.text import plural, unit_in_words

MAX_LINES_SAID = 6
NO_FIT_LOG10_P = -2.0


def noise_text(document: Mapping[str, Any]) -> str:
    """Return the summary that ``station noise`` prints: every term with its 95 % interval, or its bound."""
    origin = document["provenance"]
    who, files = unit_in_words(origin["model"], origin["serial"]), plural(len(origin["files"]), "file")
    said = [f"{who}: {files}, 95 % intervals"]
    said += noise_lines(document["channels"])
    said += [f"left out: {text}" for text in document["left_out"]]
    return "\n".join([*said, *(f"warning: {text}" for text in document["warnings"])])


def noise_lines(channels: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield what is said of every channel."""
    for each in channels:
        yield f"{each['channel']}, {each['seconds']:.4g} s of {each['recording']} at {_rates_text(each)}"
        for term in each["terms"].values():
            yield f"   {term['name'] + ' ' + term['symbol']:<24}{term_text(term)}"
        yield from (f"   {each_text}" for each_text in condition_texts(each))
        rest = [term for name, term in each["terms"].items() if name != "quantisation"]
        if all("below" in term for term in rest) and not each["conditions"]:
            yield "   count size or rounding hides the other terms"
        elif each["log10_p"] < NO_FIT_LOG10_P:
            yield "   the five terms do not fit this curve: their intervals are widened by the misfit"
        for line in each["lines"][:MAX_LINES_SAID]:
            yield f"   {'line':<24}{line_text(line)}"
        if more := each["lines"][MAX_LINES_SAID:]:
            yield f"   and {plural(len(more), 'weaker line')}"


def _rates_text(channel: Mapping[str, Any]) -> str:
    """Return the rate of the rows, and that of the sensor where a condition says it is another."""
    own = [each["values"]["sensor_hz"] for each in channel["conditions"] if "sensor_hz" in each["values"]]
    sensor = f" (sensor {own[-1]:.5g} Hz)" if own else ""
    return f"{channel['rate_hz']:.5g} Hz{sensor}"


def noise_summary(channels: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a line for every channel: the terms that its curve shows, and how many lines its spectrum has."""
    for each in channels:
        seen = [
            f"{t['symbol']} {t['value']:.3g} {t['unit']}"
            for t in each["terms"].values()
            if t.get("value") is not None
        ]
        lines = [plural(len(each["lines"]), "line")] if each["lines"] else []
        named = [one["name"].replace("_", " ") for one in each["conditions"]]
        yield f"{each['channel']:<16}{', '.join([*seen, *lines, *named])}"


def term_text(term: Mapping[str, Any]) -> str:
    """Return a term with its interval, or the bound where the curve does not show it."""
    if is_undetermined(term):
        return "not determined"
    if "below" in term:
        return f"not detected, below {term['below']:.3g} {term['unit']}"
    return f"{term['value']:.3g} {term['unit']}, {term['low']:.3g} to {term['high']:.3g}"


def is_undetermined(term: Mapping[str, Any]) -> bool:
    """Say whether a term has neither value nor bound."""
    return term.get("value", 0.0) is None


def condition_texts(channel: Mapping[str, Any]) -> list[str]:
    """Return a channel's conditions, a text each with its stable name before it."""
    return [f"{each['name'].replace('_', ' ')}: {each['text']}" for each in channel["conditions"]]


def line_text(line: Mapping[str, Any]) -> str:
    """Return a line's frequency, amplitude, share of the variance and chance."""
    size = measured(line["amplitude"], line["amplitude_std"], line["unit"])
    share = f"{100 * line['share']:.2g} % of the variance"
    return f"{line['hertz']:.6g} Hz, {size}, {share}, {p_text(line['log10_p'])}"
