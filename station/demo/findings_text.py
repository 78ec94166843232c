"""What the demo's campaign showed of the error that nobody declared: its cause, and the error before and after."""

from collections.abc import Iterator, Mapping
from typing import Any

from station.demo.unit import COEFFICIENT, EFFECT, KEY
from station.results.diagnosis.diagnosis_wording import p_text

SHOWN = 4.0  # standard uncertainties from which on a coefficient is shown that was not planted


def findings_lines(diagnosis: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a `diagnosis/1`."""
    yield "what the model lacked"
    causes = [each for each in diagnosis["findings"] if each["kind"] != "bench"]
    for each in causes:
        yield f"  cause: {each['effect']}, {each['confidence']} (by chance {p_text(each['log10_p'])})"
        yield from _coefficients(each)
    if not causes:
        yield "  nothing was found: repeat with longer dwells (--dwell-s 60)"
    held_out = [each for each in diagnosis["error"] if each.get("held_out_after")]
    if causes and held_out:
        most = max(held_out, key=lambda each: each["held_out_before"] / each["held_out_after"])
        for name, where in (("", "in the data"), ("held_out_", "on data held out")):
            before, after = (f"{most[f'{name}{when}']:.3g} {most['unit']}" for when in ("before", "after"))
            yield f"  error of {most['quantity']} {where}: {before} without it, {after} with it"


def _coefficients(finding: Mapping[str, Any]) -> Iterator[str]:
    for name, found in finding["coefficients"].items():
        planted = COEFFICIENT if (finding["effect"], name) == (EFFECT, KEY) else 0.0
        if planted or abs(found["value"]) > SHOWN * found["std"]:
            value = f"{found['value']:.4f} {finding['unit']}, u {found['std']:.4f}"
            yield f"  {name}: {value}; the simulator has {planted:g}"
