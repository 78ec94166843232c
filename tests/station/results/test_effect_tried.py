"""What is said of an effect that was tried, for each way that a diagnosis may have gone."""

from math import log
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from procedures.diagnosis.result import EffectTest, Finding, TooLarge
from station.results import effect_tried

NAME = "accelerometer.own"
FILE: Any = SimpleNamespace(
    name=NAME,
    effect=None,
    term=SimpleNamespace(
        parameters={"tau_s": SimpleNamespace(unit="s")},
        missing=lambda excitation: excitation,
        at_ends=lambda values: [f"tau_s {values['tau_s']:.0f} stands at the end of its range"],
    ),
)


def finding(effect: str, *aliases: str) -> Finding:
    return Finding(
        effect, "instrument", ("x", "tau_s"), np.array([2e-5, 40.0]), np.array([1e-6, 2.0]), "g", {}, "likely",
        aliases, "", -20.0, 5.0,
    )  # fmt: skip


def diagnosis(
    *findings: Finding, p: float | None = None, too_large: tuple[TooLarge, ...] = (), missing: tuple[str, ...] = ()
) -> Any:
    other = EffectTest("accelerometer.cubic", 90.0, -50.0, -45.0)
    tried = [other] if p is None else [other, EffectTest(NAME, 30.0, log(p) - 3, log(p))]
    evidence = SimpleNamespace(excitation=missing)
    return SimpleNamespace(
        findings=findings, tried=tried, too_large=too_large, evidence=evidence, verdict="partly"
    )


def said_of(found: Any, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the lines that are said where campaigns are diagnosed so."""
    monkeypatch.setattr(effect_tried, "diagnose", lambda *_: found)
    return effect_tried.tried_text(FILE, []).splitlines()


OTHER, OWN = TooLarge("accelerometer.quadratic", 8.54), TooLarge(NAME, 12.3)
GYROSCOPE = TooLarge("gyroscope.jump", 7.0)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (diagnosis(finding(NAME), finding("clock.rate")), "it is there, likely"),
        (diagnosis(missing=("temp_c", "B")), "left out: temp_c, B not recorded"),
        (
            diagnosis(finding("slab.tilt", NAME), finding("clock.rate"), p=1e-9),
            "these campaigns cannot tell it from slab.tilt",
        ),
        (
            diagnosis(),
            "these campaigns cannot tell it: the model's own parameters take its place, or nothing excites it",
        ),
        (diagnosis(p=0.011), "not seen: over all that was tried p = 0.011"),
        (diagnosis(p=0.011, too_large=(OWN,)), "not seen: over all that was tried p = 0.011"),
        (
            diagnosis(p=0.009, too_large=(OTHER, OWN)),
            "seen (over all that was tried p = 0.009) and not kept: it would be 12 times larger than is plausible",
        ),
        (
            diagnosis(p=0.009, too_large=(GYROSCOPE, OTHER)),
            "seen (over all that was tried p = 0.009) and not kept: accelerometer.quadratic explains more, though "
            "that would be 8.5 times larger than is plausible",
        ),
        (
            diagnosis(p=0.009, too_large=(GYROSCOPE,)),
            "seen (over all that was tried p = 0.009) and not kept: what is left out of a fit, or what was found "
            "besides, does not bear it out",
        ),
    ],
)
def test_what_became_of_it_is_said_in_a_sentence(found: Any, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = said_of(found, monkeypatch)
    assert lines[0] == f"{NAME}: {said}"
    assert lines[-1] == "verdict: partly"


def test_its_coefficients_stand_in_their_own_units_with_what_else_it_could_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = diagnosis(finding(NAME, "slab.tilt", "clock.rate"), finding("clock.rate"), finding("clock.rate"))
    assert said_of(found, monkeypatch)[1:] == [
        "  x          0.0000200 +- 0.0000010 g",
        "  tau_s      40.0 +- 2.0 s",
        "  tau_s 40 stands at the end of its range",
        "  it could also be slab.tilt, clock.rate",
        "beside it: clock.rate",
        "verdict: partly",
    ]
    assert said_of(diagnosis(finding(NAME)), monkeypatch)[4:] == ["verdict: partly"]
    assert said_of(diagnosis(finding("clock.rate")), monkeypatch)[1:] == [
        "beside it: clock.rate",
        "verdict: partly",
    ]
