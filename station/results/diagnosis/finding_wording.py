"""What a finding of a `diagnosis/2` says, in words: probability, size, place, error held out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees, floor, hypot
from typing import Any, get_args

from procedures.inference.priors import Confidence, word
from procedures.inference.result import Fault
from procedures.units import ARCSEC_PER_DEG, ARCSEC_PER_RAD, PPM_PER_ONE, UG_PER_G
from station.results.solution_text import measured
from station.text import plural, significant

PROPOSED = "proposed"
PROPOSED_IN_WORDS = "proposed: it is not in the catalogue and not in the solution; confirm it with other data"
SAMPLE_EFFECTS = (
    "auxiliary.periodic", "accelerometer.count_periodic", "gyroscope.count_periodic", "disturbance.line",
    "accelerometer.vibration_rectification",
    "gyroscope.vibration_rectification",
)  # fmt: skip
FALLS = 0.995  # of an error held out, from which on it is the same
ROUNDING = 1e-9  # ug, deg/h ..: no error of an instrument is as small
NEGLIGIBLE = 0.01  # a probability that is not listed
CERTAIN = 0.999  # a probability from which on no more digits are printed
BEYOND_BELIEF = 10.0  # times its expected size, from which on a coefficient is questioned
MIN_LOG10_P = -300  # below which a p-value is only known to be below
NEARLY_ONE = 0.99  # a p-value from which on no more digits are printed
NOTABLE_U = 3.0  # size of a coefficient over its u, from which on the headline names it
MAX_COEFFICIENTS = 12  # of a finding that are listed; the largest in units of u
READINGS_SHOWN = 6
MANY = 3  # findings of one error term: more are one cause, with its number, first and last time


def confidence_in_words(finding: Mapping[str, Any]) -> str:
    """Return in words how sure a finding's name is, and how much of the error held out it removes."""
    text = f"{finding['confidence']}, probability {probability_text(finding['probability'])}"
    if finding["confidence"] == PROPOSED:
        text = f"{PROPOSED_IN_WORDS}; probability {probability_text(finding['probability'])}"
    if finding["aliases"]:
        joint = finding.get("joint_probability", 1.0)
        text += f"; the data cannot separate it from the alternatives (together {probability_text(joint)})"
    whole = "the samples' variance" if is_of_samples(finding) else "the squared held-out error"
    return f"{text}; it explains {share} of {whole}" if (share := explained(finding)) else text


def probability_text(p: float) -> str:
    """Return a probability as text: ``0.42``, ``0.996``, ``> 0.999``; never 0 or 1, nor one of another word."""
    if p > CERTAIN:
        return f"> {CERTAIN}"
    if p < NEGLIGIBLE:
        return f"< {NEGLIGIBLE}"
    digits = 3 if p > 0.95 else 2
    if word(round(p, digits)) == word(p):
        return f"{p:.{digits}f}"
    finer = 10 ** (digits + 1)
    return f"{floor(p * finer) / finer:.{digits + 1}f}"  # just below the limit of a word


def probabilities_text(findings: Sequence[Mapping[str, Any]]) -> str:
    """Return the probability of findings, from the least to the largest where they differ."""
    low, high = (of(each["probability"] for each in findings) for of in (min, max))
    texts = dict.fromkeys(probability_text(p) for p in (low, high))
    return " to ".join(texts)


def p_text(log10_p: float) -> str:
    """Return a p-value as text: ``p = 0.38``, ``p = 2e-12``, ``p < 1e-300``, ``p > 0.99``."""
    if log10_p <= MIN_LOG10_P:
        return f"p < 1e{MIN_LOG10_P}"
    p = 10**log10_p
    if p > NEARLY_ONE:
        return f"p > {NEARLY_ONE}"
    return f"p = {p:.2g}" if log10_p > -3 else f"p = {p:.0e}"


def share_text(share: float) -> str:
    """Return a share (0 to 1) in percent, with two digits below 10 %."""
    return f"{100 * share:.0f} %" if share > 0.095 else f"{100 * share:.2g} %"


OF_SAMPLES = {  # what is found sample by sample, or row by row, and has no entry in the catalogue
    "auxiliary.periodic": "Error that repeats with an auxiliary channel",
    "accelerometer.count_periodic": "Error that repeats with an accelerometer's own count",
    "gyroscope.count_periodic": "Error that repeats with a gyroscope's own count",
    "disturbance.line": "Sinusoidal disturbance of one frequency",
    "procedure.wrong_row": "Row of a rate table that contradicts the others",
}
FAULTS: Mapping[Fault, str] = {
    "wrong row": "Single wrong samples",
    "frozen": "Output frozen at one value",
    "clipped": "Output clipped at the end of its range",
    "noise": "Noise that is different from some moment on",
}


def importance(cause: Mapping[str, Any]) -> tuple[int, float, float]:
    """Return by what causes are sorted: the surest in words first, of these what explains most."""
    p = cause.get("joint_probability", 0.0) if "effect" not in cause else cause["probability"]
    return get_args(Confidence).index(word(p)), -round(cause.get("share", 0.0), 2), -p


def meaning_of(finding: Mapping[str, Any]) -> str:
    """Return what a finding is, in words: ``Second-order nonlinearity of the accelerometers``."""
    from procedures.effects import CATALOGUE

    name = finding["effect"]
    if (fault := finding.get("fault", "")) or name in OF_SAMPLES:
        return FAULTS[fault] if fault else OF_SAMPLES[name]
    return CATALOGUE[name].title(finding.get("shape", "")) if name in CATALOGUE else ""


def shape_of(finding: Mapping[str, Any]) -> str:
    """Return the shape of a finding, "" where `meaning_of` says it."""
    from procedures.effects import CATALOGUE

    shape, known = str(finding.get("shape", "")), CATALOGUE.get(finding["effect"])
    return "" if known is not None and shape in known.of_shape else shape


EQUATIONS = {  # of what acts sample by sample, a the channel, the count or the time
    "auxiliary.periodic": "sum of cos_h cos(2 pi h a / P) + sin_h sin(2 pi h a / P)",
    "accelerometer.vibration_rectification": "K (a - mean)^2",
    "gyroscope.vibration_rectification": "K (sum of (a - mean)^2 over the accelerometers)",
    "auxiliary.channel": "c a(t - lag)",
    "disturbance.line": "sum of cos_h cos(2 pi h f t) + sin_h sin(2 pi h f t), or a sine whose phase drifts",
}  # fmt: skip


def equation_of(finding: Mapping[str, Any]) -> str:
    """Return what a finding adds to the sensors' output, as the catalogue has it."""
    if finding.get("fault"):
        return ""
    if is_of_samples(finding):
        return EQUATIONS.get(finding["effect"], EQUATIONS["auxiliary.periodic"])
    if "term" in finding:  # of a file of its own, not of the catalogue
        return " + ".join(f"c ({term})" for term in finding["term"])
    from procedures.effects import CATALOGUE

    return CATALOGUE[finding["effect"]].physics if finding["effect"] in CATALOGUE else ""


def is_of_samples(finding: Mapping[str, Any]) -> bool:
    """Say whether a finding is one of `procedures.samples.sample_effects`: it is not in the means."""
    lagged = finding["effect"] == "auxiliary.channel" and bool(finding.get("shape"))
    return lagged or finding["effect"] in SAMPLE_EFFECTS


def explained(finding: Mapping[str, Any]) -> str:
    """Return the share of the squared error held out, or of the samples' variance, that a finding explains."""
    share = finding.get("share", 0.0)
    return share_text(share) if share >= NEGLIGIBLE else ""


def most_reduced(document: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the ``error`` of a `diagnosis/2` that falls most where held out in turn, None where none falls."""
    own = [each for each in document["error"] if not each["method"].startswith("validation")]
    known = [each for each in own if each.get("held_out_before") and each.get("held_out_after")]
    best = min(known, key=lambda each: each["held_out_after"] / each["held_out_before"], default=None)
    return best if best and best["held_out_after"] < FALLS * best["held_out_before"] else None


def error_text(error: Mapping[str, Any], held: str = "held_out_") -> tuple[str, str]:
    """Return an error without and with the findings in the model, and its unit: ``4.8 -> 1``, ``deg/h``."""
    scale, unit = shown_unit(error["unit"])
    if not {f"{held}before", f"{held}after"} <= error.keys():
        return "", unit
    values = (error[f"{held}{when}"] * scale for when in ("before", "after"))
    return " -> ".join(f"{value:.3g}" if value > ROUNDING else "0" for value in values), unit


def notes(finding: Mapping[str, Any]) -> list[str]:
    """Return what else is to be reported of a finding, a sentence each."""
    from procedures.effects import CATALOGUE

    found = list[str]()
    if shape := shape_of(finding):
        known = CATALOGUE.get(finding["effect"])
        found.append(f"shape: {shape}" if known is not None and known.law(shape) is not None else shape)
    if (angle := finding.get("levelling_deg")) is not None:
        along = [f"{degrees(c['value']):.2f} along {n[-1]}" for n, c in finding["coefficients"].items()]
        found.append(f"the face is {angle:.2f} deg off the vertical: {', '.join(along)}")
    if (times := finding.get("times_expected", 0.0)) > BEYOND_BELIEF:
        found.append(
            f"it is {significant(times)} times the size expected of a fibre-optic IMU: check the unit and the "
            "channel, unless the sensor is of a lower grade"
        )
    if same := finding.get("same_here"):
        found.append(
            f"at the one attitude recorded it is indistinguishable from {both(same)}: record a second attitude"
        )
    if finding.get("unit") == "position":
        actual = both([str(round(one["value"])) for one in finding["coefficients"].values()])
        found.append(f"the cube stood in position {actual}: record it so")
    if finding.get("unit") == "direction":
        found.append(
            "these rotations are labelled with the wrong direction: with these labels the gyroscopes would count "
            "backwards, but the Earth's rate in the dwells shows that they count forwards; this diagnosis uses "
            "the opposite direction, `station solve` uses the labels"
        )
    position = finding["where"].get("position")
    if isinstance(position, list):
        found.append(
            f"the data cannot determine which of these positions it was: it is solved as position {position[0]}; "
            f"another position would change face parallelism and misalignments; their uncertainties include that"
        )
    return found


def both(names: Sequence[str]) -> str:
    """Return names as an English list."""
    once = list(dict.fromkeys(names))
    return " and ".join([", ".join(once[:-1]), once[-1]] if len(once) > 1 else once)


TIMES = {"from_s": "from {} s", "to_s": "to {} s", "at_s": "at {} s", "after_s": "at {} s"}  # by key of `where`
FILES = ("file", "in")
PLACES = {
    "after": "after {}", "campaign": "campaign {}", "position": "position {}", "channel": "channel {}",
    "line": "line {}", "or_line": "or line {}", "point": "point {}", "or_point": "or point {}",
    "rate_deg_s": "at {} deg/s",
}  # fmt: skip
COUNTED = "others"  # of a finding that stands for several: how many more there are


def where_text(where: Mapping[str, Any]) -> str:
    """Return what a finding is about: ``at 12 s of dwell_03.csv, position 3 or 4``."""
    time = " ".join(text.format(_part(key, where[key])) for key, text in TIMES.items() if key in where)
    file = ", ".join(_part(key, where[key]) for key in FILES if key in where)
    others = [key for key in where if key not in {*TIMES, *FILES, COUNTED}]
    texts = [
        " of ".join(part for part in (time, file) if part),
        *(PLACES.get(key, f"{key} {{}}").format(_part(key, where[key])) for key in others),
    ]
    several = f"{where[COUNTED] + 1} times, the surest " if COUNTED in where else ""
    return several + ", ".join(text for text in texts if text)


def _part(key: str, value: Any) -> str:
    parts = value if isinstance(value, list) else [value]
    joined = " or " if key == "position" else ", "  # one position of several, but all channels
    return joined.join(f"{each:.6g}" if isinstance(each, float) else str(each) for each in parts)


def place_of(findings: Sequence[Mapping[str, Any]]) -> str:
    """Return where findings of one error term act: of several how many, the recordings, first and last time."""
    first = findings[0]["where"]
    if len(findings) == 1:
        return where_text(first)
    files = [where_text({key: each["where"][key] for key in FILES if key in each["where"]}) for each in findings]
    known = list(dict.fromkeys(file for file in files if file))
    where = f" in {both(known)}" if 0 < len(known) <= MANY else f" in {len(known)} recordings" if known else ""
    begins = sorted(t for each in findings if (t := _begin(each["where"])) is not None)
    times = f", first at {begins[0]:.6g} s, last at {begins[-1]:.6g} s" if begins and len(known) == 1 else ""
    return f"{plural(sum(1 + each['where'].get(COUNTED, 0) for each in findings), 'time')}{where}{times}"


def _begin(where: Mapping[str, Any]) -> float | None:
    return next((where[key] for key in ("at_s", "from_s", "after_s") if key in where), None)


@dataclass(frozen=True, slots=True)
class CoefficientRow:
    """A coefficient's name, its value with u and unit, and its size in u as text and as a number."""

    name: str
    value: str
    size: str
    strength: float

    @property
    def text(self) -> str:
        """Name and value in one; a single size has no name."""
        return self.value if self.name == "value" else f"{self.name} {self.value}"


def coefficient_rows(finding: Mapping[str, Any]) -> list[CoefficientRow]:
    """Return a finding's largest coefficients."""
    found, own = finding["coefficients"], finding.get("units", {})  # units: of the parameters of a term
    rows = list[CoefficientRow]()
    for name, c in found.items():
        if c["std"] > 0:
            scale, unit = (1.0, own[name]) if name in own else coefficient_unit(name, finding["unit"])
            value = measured(c["value"] * scale, c["std"] * scale, unit)
            strength = abs(c["value"]) / c["std"]
            rows.append(CoefficientRow(_wave_in_words(name), value, size_in_sigmas(strength), strength))
    kept = sorted(rows, key=lambda row: -row.strength)[:MAX_COEFFICIENTS]
    return [row for row in rows if row in kept]


WAVES = {"cos": "cosine", "sin": "sine"}


def _wave_in_words(name: str) -> str:
    """Return ``gx.sin1`` as ``gx sine 1``: the sine of the first harmonic; any other name as it is."""
    sensor, _, wave = name.rpartition(".")
    return f"{sensor} {WAVES[wave[:3]]} {wave[3:]}" if wave[:3] in WAVES and wave[3:].isdigit() else name


def amplitudes(finding: Mapping[str, Any]) -> list[CoefficientRow]:
    """Return the amplitude of each harmonic of a periodic finding, none of another one."""
    found, (scale, unit) = finding["coefficients"], shown_unit(finding["unit"])
    rows = list[CoefficientRow]()
    for name, sine in found.items():
        sensor, _, wave = name.rpartition(".")
        cosine = found.get(f"{sensor}.cos{wave[3:]}")
        if wave[:3] != "sin" or cosine is None:
            continue
        size = hypot(sine["value"], cosine["value"])
        std = hypot(sine["value"] * sine["std"], cosine["value"] * cosine["std"]) / size if size > 0 else 0.0
        if std > 0:
            harmonic = "amplitude" if wave[3:] == "1" else f"harmonic {wave[3:]}"
            value = measured(size * scale, std * scale, unit)
            rows.append(CoefficientRow(f"{sensor} {harmonic}", value, size_in_sigmas(size / std), size / std))
    return rows


def coefficient_unit(name: str, unit: str) -> tuple[float, str]:
    """Return the same of a coefficient: a time constant is in s, ``x.2`` of an effect in g/K in g/K^2."""
    from procedures.effects.excitation import UNITS_OF_COEFFICIENTS

    if name in UNITS_OF_COEFFICIENTS:
        return 1.0, UNITS_OF_COEFFICIENTS[name]
    scale, shown = shown_unit(unit)
    order = name.rpartition(".")[2]
    return scale, f"{shown}^{order}" if shown.endswith("/K") and order.isdigit() and int(order) > 1 else shown


def size_in_sigmas(sigmas: float) -> str:
    """Return how large a coefficient is in units of its standard uncertainty u, as text."""
    return f"{sigmas:.2g} u" if sigmas >= 1e6 else f"{sigmas:.0f} u" if sigmas >= 10 else f"{sigmas:.1f} u"


def notable_sizes(finding: Mapping[str, Any], most: int = 3) -> str:
    """Return the ``most`` coefficients that stand out, else the largest."""
    rows = sorted(amplitudes(finding) or coefficient_rows(finding), key=lambda row: -row.strength)
    notable = [row.text for row in rows[:most] if row.strength >= NOTABLE_U]
    return ", ".join(notable or [row.text for row in rows[:1]])


def shown_unit(unit: str) -> tuple[float, str]:
    """Return by what a value in a file's ``unit`` is multiplied for people, and the unit it then has.

    An error in deg is shown in arcsec, deg/h as it is. Only what stands before the first ``/`` is changed: g/g^2
    becomes ug/g^2, 1/K ppm/K.
    """
    if unit == "deg":
        return ARCSEC_PER_DEG, "arcsec"
    head, slash, rest = unit.partition("/")
    scale, name = {
        "g": (UG_PER_G, "ug"),
        "rad": (ARCSEC_PER_RAD, "arcsec"),
        "1": (PPM_PER_ONE, "ppm"),
        "": (PPM_PER_ONE, "ppm"),
    }.get(head, (1.0, head))
    return scale, f"{name}{slash}{rest}"


def proposed_in_words(finding: Mapping[str, Any]) -> list[str]:
    """Return sentences of a proposed finding: its term, its error held out, how many terms read the same."""
    if finding["confidence"] != PROPOSED:
        return []
    held, count = finding["held_out_sigmas"], finding["readings_in_all"]
    alike = (
        f"the data cannot separate it from {count} other {'term' if count == 1 else 'terms'}"
        if count
        else "no other tested term fits as well"
    )
    return [
        f"error of its rows when held out: {held['before']:.2f} sigma without it, "
        f"{held['after']:.2f} with it (rms)",
        alike,
        *([f"measure next: {finding['separate_by']}"] if finding["separate_by"] else []),
    ]


def readings_in_words(finding: Mapping[str, Any]) -> list[str]:
    """Return the terms that read the same here, the best first, each with how alike they are."""
    return [
        f"{_term(one)}, correlation {one['correlation']:.3f}"
        for one in finding.get("readings", ())[:READINGS_SHOWN]
    ]


def _term(one: Mapping[str, Any]) -> str:
    several = len(one["term"]) > 1
    return " + ".join(f"c{i if several else ''} ({term})" for i, term in enumerate(one["term"], 1))
