"""What the demo's campaign showed of the error that nobody declared: its cause, and the error before and after."""

from collections.abc import Iterator, Mapping
from typing import Any

from procedures.units import UG_PER_G
from station.demo.unit import AXIS, COEFFICIENT, EFFECT
from station.results.diagnosis.diagnosis_wording import chance_text


def story_lines(diagnosis: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a `diagnosis/1`."""
    yield "what the model lacked"
    causes = [each for each in diagnosis["findings"] if each["kind"] != "bench"]
    for each in causes:
        chance = chance_text(each["log10_p"])
        yield f"  cause: {each['effect']}, {each['confidence']} (by chance {chance})"
        yield from _coefficients(each)
    if not causes:
        yield "  nothing was found: repeat with longer dwells (--dwell-s 100)"
    error = max(diagnosis["error"], key=lambda each: each["held_out_before"] / each["held_out_after"])
    scale, unit = (UG_PER_G, "ug") if error["unit"] == "g" else (1.0, error["unit"])
    for name, where in (("", "in the data"), ("held_out_", "on data held out")):
        before, after = (scale * error[f"{name}{when}"] for when in ("before", "after"))
        yield f"  error of {error['quantity']} {where}: {before:.3g} {unit} without it, {after:.3g} {unit} with it"


def _coefficients(finding: Mapping[str, Any]) -> Iterator[str]:
    per_g = finding["unit"].startswith("g")
    scale, unit = (UG_PER_G, f"u{finding['unit']}") if per_g else (1.0, finding["unit"])
    for name, found in finding["coefficients"].items():
        is_planted = finding["effect"] == EFFECT and name in {AXIS, f"{AXIS}.1"}
        planted = scale * COEFFICIENT if is_planted else 0.0
        value, std = scale * found["value"], scale * found["std"]
        if is_planted or abs(value) > 2 * std:
            yield f"  {name}: {value:.3f} {unit}, u {std:.3f}; the simulator has {planted:g}"
