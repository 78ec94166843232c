"""What a `means/2` says, as the document that text and HTML of every diagnosis are laid out from."""

from collections.abc import Iterator, Mapping, Sequence
from math import log
from typing import Any

from procedures.frames import AXES
from procedures.inference.result import UNEXPLAINED_LOG_P
from station.results.diagnosis.diagnosis_document import DiagnosisDocument, Lines, Table, causes_of, error_tables
from station.results.diagnosis.diagnosis_wording import (
    PROBABILITY_NOTE,
    nameless_in_words,
    not_separable_in_words,
    terms_in_words,
)
from station.results.diagnosis.finding_wording import p_text, probability_text
from station.results.diagnosis.means_document import LEAST_FREE
from station.results.solution_text import measured
from station.text import significant

NOT_CHECKED = "solved, but not checked"
MICRO = 1e6


def document_of_means(found: Mapping[str, Any]) -> DiagnosisDocument:
    """Return a `means/2` as a document."""
    part = found.get("accelerometer")
    is_checked = part is not None and part["degrees_of_freedom"] >= LEAST_FREE
    return DiagnosisDocument(
        verdict=found["verdict"],
        title=found["verdict"] if is_checked else NOT_CHECKED,
        headline=_headline(found, part) if part and is_checked else _not_checked(part),
        causes=causes_of(found),
        cause_note=PROBABILITY_NOTE if any(each["aliases"] for each in found["findings"]) else "",
        not_separable=tuple(not_separable_in_words(found)),
        measure_next=found["next_measurement"],
        sections=tuple(each for each in _sections(found) if each),
        not_observable=", ".join(found["not_observable"]),
        warnings=tuple(found["warnings"]),
    )


def _sections(found: Mapping[str, Any]) -> Iterator[Table | Lines]:
    yield Table(
        "poses that contradict the others",
        "<<<",
        ("pose", "specific force less gravity", "probability"),
        tuple(_wrong_poses(found["wrong_poses"])),
    )
    yield Table("values", "<<", ("parameter", "value +- u"), tuple(_values(found)))
    yield from error_tables(found["error"] if found["findings"] else ())
    yield Lines("residuals", tuple(_residuals(found)))


def _not_checked(part: Mapping[str, Any] | None) -> str:
    if part is None:
        return "The poses give a mean output of the gyroscopes. No accelerometer is calibrated."
    return (
        "There are as many unknowns as poses, so no residual can show an error. Repeat poses, or add poses "
        "between the faces, to check the result."
    )


def _headline(found: Mapping[str, Any], part: Mapping[str, Any]) -> str:
    wrong = found["wrong_poses"]
    held_out = [each for each in wrong if each["is_held_out"]]
    fit = " ".join(filter(None, (terms_in_words(found), _against_noise(found, part), _nameless(found))))
    if not wrong:
        is_quiet = found["verdict"] == "unexplained" or found["findings"]
        return fit if is_quiet else f"No pose contradicts the others. {fit}"
    if not held_out:
        either = {one["pose"]: one for each in wrong for one in (*each["alternatives"], each)}
        which = " or ".join(f"{_name(one)} ({probability_text(one['probability'])})" for one in either.values())
        return (
            f"A pose contradicts the others, but the data cannot determine which: {which}. The values are those "
            f"of all poses. {fit}"
        )
    others = found["poses"] - len(held_out)
    texts = [
        f"{_name(each)} contradicts the {others} others (probability {probability_text(each['probability'])}): "
        f"its specific force differs from gravity by {_off(each)}.{_otherwise(each)}"
        for each in held_out
    ]
    text = " ".join(each[0].upper() + each[1:] for each in texts)
    return f"{text} The values below are without {'it' if len(held_out) == 1 else 'them'}. {fit}"


def _nameless(found: Mapping[str, Any]) -> str:
    texts = [f"{c['what']} (probability {probability_text(c['joint_probability'])})" for c in found["unnamed"]]
    return nameless_in_words(texts) if texts else ""


def _otherwise(wrong: Mapping[str, Any]) -> str:
    """Return what else it may be where that is not unlikely: another pose is wrong, or none alone."""
    if wrong["confidence"] != "possible":
        return ""
    others = [f"{_name(one)} is wrong" for one in wrong["alternatives"]]
    return f" Otherwise {' or '.join([*others, 'it is the scatter of all poses'])}."


def _against_noise(found: Mapping[str, Any], part: Mapping[str, Any]) -> str:
    """Return a sentence on the residuals against the noise, which the table states or does not."""
    residual, free = part["residual_rms_mg"], part["degrees_of_freedom"]
    if "log10_p" not in found:
        return (
            f"The table states no standard deviations: only the scatter of the poses, {significant(residual)} mg "
            f"rms, says how large the noise is."
        )
    test = f"chi2 {part['chi2']:.4g}, {free:.3g} degrees of freedom, {p_text(found['log10_p'])}"
    if found["log10_p"] < UNEXPLAINED_LOG_P / log(10):
        times = significant((part["chi2"] / free) ** 0.5)
        what = "With that in the model, residuals still" if found["findings"] else "Residuals"
        return (
            f"{what} exceed the noise that standard deviations and numbers of samples state, {times} times "
            f"({test}). The uncertainty treats them as scatter of all poses. A single wrong pose may change a "
            f"value by more."
        )
    return f"Residuals are consistent with the noise that the table states ({test})."


def _name(pose: Mapping[str, Any]) -> str:
    return f"pose {pose['pose']} (line {pose['line']})"


def _off(wrong: Mapping[str, Any]) -> str:
    off, sigmas = wrong["off_mg"], wrong["sigmas"]
    return f"{measured(off, abs(off) / sigmas, 'mg')}, {sigmas:.3g} u"


def _wrong_poses(wrong: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str, str]]:
    """Yield the cells of each pose and of those that may be wrong in its place."""
    for each in wrong:
        yield _name(each), _off(each), probability_text(each["probability"])
        for one in each["alternatives"]:
            yield f"   or {_name(one)}", "", probability_text(one["probability"])


def _values(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for triad in ("accelerometer", "gyroscope"):
        part = found.get(triad, {})
        for key in ("scale_factor", "bias"):
            if one := part.get(key):
                for axis, value, std in zip(AXES, one["value"], one["std"], strict=True):
                    yield f"{triad} {key.replace('_', ' ')} {axis}", measured(value, std or 0.0, one["unit"])
        for i, j in ((1, 0), (2, 0), (2, 1)) if "misalignment" in part else ():
            value, std = (part["misalignment"][key][i][j] for key in ("value", "std"))
            yield f"{triad} misalignment {AXES[i]}{AXES[j]}", measured(MICRO * value, MICRO * (std or 0), "urad")


def _residuals(found: Mapping[str, Any]) -> Iterator[str]:
    if part := found.get("accelerometer"):
        free, used = (
            part["degrees_of_freedom"],
            found["poses"] - sum(e["is_held_out"] for e in found["wrong_poses"]),
        )
        determined = f"{used} poses less {used - free:.3g} parameters that they determine"
        yield f"residual: {part['residual_rms_mg']:.3g} mg rms, {free:.3g} degrees of freedom ({determined})"
        if "noise_rms_mg" in part:
            yield f"noise by the standard deviations in the table: {part['noise_rms_mg']:.3g} mg rms"
        if "held_out_rms_mg" in part:
            yield f"held out: {part['held_out_rms_mg']:.3g} mg rms, each pose predicted from the others"
    if earth := found.get("gyroscope", {}).get("earth_rate_in_bias"):
        unit = found["gyroscope"]["bias"]["unit"]
        yield f"the gyroscopes' bias includes the Earth's rate: up to {earth:.2g} {unit}"
