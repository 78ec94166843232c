"""Terms that a search proposes, as findings of `diagnosis/2`, with the measurement that separates their readings.

They change neither the diagnosis' verdict nor its solution. A measurement is given in words and as steps of
`plan/1`.
"""

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from procedures.discovery.discover import Discovery, Proposal
from procedures.discovery.next_plan import LONGER, SPEEDS_DEG_S, NextMeasurement, next_measurement
from procedures.effects.term.effect_of_term import TermEffect
from procedures.effects.term.latex import latex_of_law
from station.files.effect_file import FORMAT
from station.files.toml_file import toml_text
from station.results.diagnosis.log_measurements import AGAIN
from station.results.diagnosis.next_measurements import DWELL_S, STATIC, Measurement, positions, turns

MEASUREMENTS: Mapping[str, Measurement] = {
    **{
        f"turns_at_{speed:g}": Measurement(
            f"turns_at_{speed:g}",
            f"Turn about each axis once more, both ways, at about {speed:g} deg/s.",
            {"turn": turns(speed_deg_s=speed)},
        )
        for speed in SPEEDS_DEG_S
    },
    "another_order": STATIC["other_order"],
    "heated": STATIC["warming_campaign"],
    "longer_rests": Measurement(
        "longer_rests",
        f"Do the twelve positions again, each for {LONGER * DWELL_S:g} s.",
        positions(range(1, 13), LONGER * DWELL_S),
    ),
}


def parted_by(found: Discovery) -> list[NextMeasurement | None]:
    """Return the measurement that parts each proposal's readings, None where it has none or nothing parts them."""
    return [next_measurement(found, one) for one in found.proposals]


def next_in_words(one: Proposal, best: NextMeasurement | None) -> str:
    """Return what to measure next to part a proposal from its readings; nothing where there are none."""
    if not one.readings:
        return ""
    if best is None:
        return "no repetition of this campaign's steps parts it from them"
    say = MEASUREMENTS[best.name].phrase
    return f"{say}: parts it from {best.parted} of them, in {best.minutes:.0f} minutes at the bench"


def planned(document: Mapping[str, Any]) -> list[Measurement]:
    """Return the measurements that the proposals of a `diagnosis/2` ask for, each once."""
    names = [one["next"]["measurement"] for one in document["findings"] if "next" in one]
    return [MEASUREMENTS[name] for name in dict.fromkeys(names)]


PROPOSED = "proposed"
MAX_READINGS = 12  # that are written; the best


def with_proposed(document: Mapping[str, Any], found: Discovery) -> dict[str, Any]:
    """Return a `diagnosis/2` with what a search proposes, each with the `effect/1` that `adopt` writes."""
    recording = document["recording"]
    nexts = parted_by(found) if recording == "campaign" else [None] * len(found.proposals)  # its steps done again
    proposed = [
        _finding(one, best) | ({} if recording == "campaign" else {"separate_by": AGAIN[recording].phrase})
        for one, best in zip(found.proposals, nexts, strict=True)
    ]
    findings = [*document["findings"], *proposed]
    return {**document, "findings": findings, "searched": {"terms": found.tried}}


def _finding(one: Proposal, best: NextMeasurement | None) -> dict[str, Any]:
    definition = definition_of(one.term)
    values = zip(one.coefficients, one.value.tolist(), one.std.tolist(), strict=True)
    known = {name: {"value": v, "std": s} for name, v, s in values if np.isfinite([v, s]).all() and s > 0}
    units = {name: shape.unit for name, shape in one.term.parameters.items()}
    return {
        "effect": f"{one.term.triad}.{one.term.name}", "kind": "instrument", "coefficients": known,
        "unit": one.term.unit, **({"units": units} if units else {}), "where": {}, "confidence": PROPOSED,
        "share": float(one.share), "aliases": [], "separate_by": next_in_words(one, best),
        **({"next": {"measurement": best.name, "minutes": best.minutes, "parts": best.parted}} if best else {}),
        "probability": float(one.probability),
        "term": list(one.term.terms), "latex": latex_of_law(one.term),
        "readings": [
            {"term": list(each.term.terms), "unit": each.term.unit, "latex": latex_of_law(each.term),
             "correlation": float(each.similarity), "worse_by": float(each.worse),
             **({"expected_chi2": best.expected[i]} if best else {})}
            for i, each in enumerate(one.readings[:MAX_READINGS])
        ],
        "readings_in_all": len(one.readings),
        "held_out_sigmas": {"before": one.held_out[0], "after": one.held_out[1]},
        "sha256": hashlib.sha256(definition.encode()).hexdigest(), "definition": definition,
    }  # fmt: skip


def definition_of(term: TermEffect) -> str:
    """Return a term as the text of an `effect/1`."""
    shape = {
        name: {"unit": one.unit, "low": _short(one.low), "high": _short(one.high)}
        for name, one in term.parameters.items()
    }
    one: Sequence[str] | str = term.terms[0] if len(term.terms) == 1 else list(term.terms)
    return toml_text({
        "format": FORMAT, "name": term.name, "triad": term.triad, "term": one, "unit": term.unit,
        "plausible": term.plausible, "source": term.source, **({"shape": shape} if shape else {}),
    })  # fmt: skip


def _short(value: float) -> float:
    return float(f"{value:.4g}")
