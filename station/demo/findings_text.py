"""What the demo's campaign showed of the error that nobody declared: its cause, and the error before and after."""

from collections.abc import Iterator, Mapping
from typing import Any

from station.demo.unit import COEFFICIENT, EFFECT, KEY
from station.results.diagnosis.diagnosis_wording import probability_text

SHOWN = 4.0  # standard uncertainties from which on a coefficient is shown that was not planted
NOTABLE = 2.0  # standard uncertainties from which on an error is commented


def findings_lines(diagnosis: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a `diagnosis/2`."""
    causes = [each for each in diagnosis["findings"] if each["kind"] != "bench"]
    for each in causes:
        yield f"error found that the model lacked: {each['effect']}"
        yield f"  {each['confidence']}, probability {probability_text(each['probability'])}"
        yield from _coefficients(each)
    if not causes:
        yield "no error was found that the model lacked; use longer dwells (--dwell-s 60)"
    held_out = [each for each in diagnosis["error"] if each.get("held_out_after")]
    if causes and held_out:
        most = max(held_out, key=lambda each: each["held_out_before"] / each["held_out_after"])
        yield f"  {'error of ' + most['quantity']:<32}{'without it':<15}with it"
        for name, where in (("", "in the data"), ("held_out_", "in held-out data")):
            before, after = (f"{most[f'{name}{when}']:.3g} {most['unit']}" for when in ("before", "after"))
            yield f"    {where:<30}{before:<15}{after}"


def _coefficients(finding: Mapping[str, Any]) -> Iterator[str]:
    for name, found in finding["coefficients"].items():
        planted = COEFFICIENT if (finding["effect"], name) == (EFFECT, KEY) else 0.0
        if planted or abs(found["value"]) > SHOWN * found["std"]:
            error = (found["value"] - planted) / found["std"]
            value = f"{found['value']:.4f} {finding['unit']}, u = {found['std']:.4f}"
            yield f"  {name} = {value}; true value {planted:g}"
            if abs(error) > NOTABLE:  # by a wrong field
                yield f"  (error {error:+.1f} u: the assumed magnetic field is a model's, a few % off)"
