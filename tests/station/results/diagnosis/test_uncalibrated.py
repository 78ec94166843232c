"""What is said in outputs, where nobody told a triad's unit."""

from pathlib import Path

from procedures.units import DEG_H_PER_DEG_S
from station.files.effect_file import effect_in
from station.results.diagnosis.uncalibrated import in_told_unit

EFFECT = b"""format = "effect/1"
name = "warm_up"
triad = "gyroscope"
term = "exp(-t / relaxes) * lag(T, tau_s)"
unit = "deg/h/K"
plausible = 1.0
source = "a test"
shape.relaxes = {unit = "s", low = 60, high = 6000}
shape.tau_s = {unit = "s", low = 60, high = 6000}
"""


def test_the_parameters_of_an_effect_of_ones_own_stay_as_they_are() -> None:
    file = effect_in(EFFECT, Path("warm_up.toml"))
    seconds = {"value": 600.0, "std": 20.0}
    entry = {
        "effect": file.name, "unit": "deg/h/K", "definition": file.text, "sha256": file.sha256,
        "coefficients": {"x": {"value": 36.0, "std": 3.6}, "relaxes": seconds, "tau_s": seconds},
    }  # fmt: skip
    found = in_told_unit(entry, file.name, {})
    assert found["unit"] == "output/K"
    assert found["coefficients"]["x"] == {"value": 36.0 / DEG_H_PER_DEG_S, "std": 3.6 / DEG_H_PER_DEG_S}
    assert found["coefficients"]["relaxes"] == seconds
    assert found["coefficients"]["tau_s"] == seconds
    assert in_told_unit(entry, file.name, {"gyroscope": 1.0}) == entry
