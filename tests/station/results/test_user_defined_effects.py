"""User-defined error terms: confirmed by other data only, and what is said of one that was tried."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from procedures.inference.result import Finding
from station import cli
from station.files.effect_file import read_effect
from station.results import user_defined_effects
from tests.station.effect_examples import WARMING

FOUND_IN = {"campaign.toml": "c" * 64, "dwell_01.mcap": "1" * 64, "turn_x_plus.mcap": "2" * 64}
LATER = {"campaign.toml": "d" * 64, "dwell_01.mcap": "3" * 64, "turn_x_plus.mcap": "4" * 64}
UNIT = {"model": "FOG-3", "serial": "S1"}


def _adopted(folder: Path, files: dict[str, str], verdict: str, entry: dict[str, Any], *, is_found: bool) -> Path:
    solution: dict[str, Any] = {"provenance": {**UNIT, "files": files}}
    finding = {**entry, "effect": entry["name"], "confidence": "proposed"}
    document: dict[str, Any] = {"format": "diagnosis/2", "verdict": verdict, "solution": solution}
    document |= {"findings": [finding] if is_found else []}
    solution |= {} if is_found else {"effects": [entry]}
    (folder / "diagnosis.json").write_text(json.dumps(document))
    out = folder / "adopted.toml"
    assert cli.run(["effects", "adopt", str(folder / "diagnosis.json"), "--out", str(out)]) == 0
    return out


def _entry(path: Path, value: float = 2.0) -> dict[str, Any]:
    file = read_effect(path)
    known = {"coefficients": {"x": {"value": value, "std": 0.1}}}
    return {"name": file.name, "definition": file.text, "sha256": file.sha256, **known}


REPEATED, DIFFERS = "it was found in some of these recordings", "do not differ from zero"
CASES = {
    "other data": (LATER, "consistent", 2.0, ""),
    "other data by the same plan": ({**LATER, "campaign.toml": "c" * 64}, "consistent", 2.0, ""),
    "the folder that it was found in, its campaign.toml edited": (
        {**FOUND_IN, "campaign.toml": "e" * 64, "law.toml": "f" * 64}, "consistent", 2.0, REPEATED),
    "one recording of it": ({**LATER, "dwell_02.mcap": "1" * 64}, "consistent", 2.0, REPEATED),
    "both folders together": (
        {f"a/{k}": v for k, v in FOUND_IN.items()} | {f"b/{k}": v for k, v in LATER.items()},
        "consistent", 2.0, REPEATED),
    "other data, which leave more than noise": (LATER, "partly", 2.0, "the verdict is partly"),
    "other data, which do not show it": (LATER, "consistent", 0.1, DIFFERS),
}  # fmt: skip


@pytest.mark.parametrize(("files", "verdict", "value", "why"), CASES.values(), ids=CASES)
def test_what_confirms(
    files: dict[str, str], verdict: str, value: float, why: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "law.toml").write_text(WARMING)
    found = _adopted(tmp_path, FOUND_IN, "unexplained", _entry(tmp_path / "law.toml"), is_found=True)
    origin = read_effect(found).origin
    assert origin is not None
    assert origin.data == ["1" * 12, "2" * 12]
    again = read_effect(_adopted(tmp_path, files, verdict, _entry(found, value), is_found=False))
    reported = capsys.readouterr().out.splitlines()[-1]
    assert reported.startswith("proposed: " if why else "confirmed by FOG-3 S1")
    assert why in reported
    assert again.is_only_proposed is bool(why)
    assert again.origin is not None
    assert again.origin.data == origin.data


NAME = "accelerometer.own"
FILE: Any = SimpleNamespace(
    name=NAME,
    effect=None,
    term=SimpleNamespace(
        parameters={"tau_s": SimpleNamespace(unit="s")},
        missing=lambda excitation: excitation,
        at_ends=lambda values: [f"tau_s {values['tau_s']:.0f} is at the end of its range"],
    ),
)


def finding(effect: str, *aliases: str) -> Finding:
    return Finding(
        effect, "instrument", ("x", "tau_s"), np.array([2e-5, 40.0]), np.array([1e-6, 2.0]), "g", {}, 0.97, "",
        aliases=aliases,
    )  # fmt: skip


def diagnosis(
    *findings: Finding, p: float | None = None, missing: tuple[str, ...] = (), absorbed: tuple[str, ...] = ()
) -> Any:
    probabilities = {"accelerometer.cubic": 0.3} | ({} if p is None else {NAME: p})
    evidence = SimpleNamespace(excitation=missing)
    return SimpleNamespace(
        findings=findings, probabilities=probabilities, not_separable=dict.fromkeys(absorbed, ""),
        evidence=evidence, verdict="partly",
    )  # fmt: skip


def reported_of(found: Any, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the lines that are said where campaigns are diagnosed so."""
    monkeypatch.setattr(user_defined_effects, "diagnose", lambda *_: found)
    return user_defined_effects.tried_text(FILE, []).splitlines()


@pytest.mark.parametrize(
    ("found", "values"),
    [
        (diagnosis(finding(NAME), finding("clock.rate")), ("likely",)),
        (diagnosis(missing=("temp_c", "B")), ("temp_c", "B")),
        (diagnosis(finding("slab.tilt", NAME), p=0.2), ("slab.tilt",)),
        (diagnosis(p=0.12), ("0.12",)),
        (diagnosis(p=0.01, absorbed=(NAME,)), ("absorb",)),
        (diagnosis(), ("absorb",)),
    ],
)
def test_what_became_of_it_is_reported_with_its_values(
    found: Any, values: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = reported_of(found, monkeypatch)
    assert lines[0].startswith(f"{NAME}: ")
    assert all(value in lines[0] for value in values)
    assert lines[-1] == "verdict: partly"


def test_its_coefficients_stand_in_their_own_units_with_what_else_it_could_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = diagnosis(finding(NAME, "slab.tilt", "clock.rate"), finding("clock.rate"), finding("clock.rate"))
    assert reported_of(found, monkeypatch)[1:] == [
        "  x          0.0000200 +- 0.0000010 g",
        "  tau_s      40.0 +- 2.0 s",
        "  tau_s 40 is at the end of its range",
        "  it may also be slab.tilt, clock.rate",
        "also in the model: clock.rate",
        "verdict: partly",
    ]
