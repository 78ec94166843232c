"""Only data that had no part in finding an effect confirm it, however its folder is called or was edited since."""

import json
from pathlib import Path
from typing import Any

import pytest

from station import cli
from station.files.effect_file import read_effect
from tests.station.effect_examples import WARMING

FOUND_IN = {"campaign.toml": "c" * 64, "dwell_01.mcap": "1" * 64, "turn_x_plus.mcap": "2" * 64}
LATER = {"campaign.toml": "d" * 64, "dwell_01.mcap": "3" * 64, "turn_x_plus.mcap": "4" * 64}
UNIT = {"model": "FOG-3", "serial": "S1"}


def _adopted(folder: Path, files: dict[str, str], verdict: str, entry: dict[str, Any], *, is_found: bool) -> Path:
    solution: dict[str, Any] = {"provenance": {**UNIT, "files": files}}
    finding = {**entry, "effect": entry["name"], "confidence": "proposed"}
    document: dict[str, Any] = {"format": "diagnosis/1", "verdict": verdict, "solution": solution}
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


REPEATED, DIFFERS = "it was found in some of these recordings", "do not differ from nought"
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
    said = capsys.readouterr().out.splitlines()[-1]
    assert said.startswith("proposed: " if why else "confirmed by FOG-3 S1")
    assert why in said
    assert again.is_only_proposed is bool(why)
    assert again.origin is not None
    assert again.origin.data == origin.data


def test_of_an_origin_without_recordings_its_campaign_counts(tmp_path: Path) -> None:
    (tmp_path / "law.toml").write_text(WARMING)
    found = _adopted(tmp_path, FOUND_IN, "unexplained", _entry(tmp_path / "law.toml"), is_found=True)
    lines = found.read_text().splitlines()
    found.write_text("\n".join(line for line in lines if not line.startswith("data")))
    for files, is_confirmed in (({f"a/{k}": v for k, v in FOUND_IN.items()}, False), (LATER, True)):
        again = _adopted(tmp_path, files, "consistent", _entry(found), is_found=False)
        assert read_effect(again).is_only_proposed is not is_confirmed
        found = tmp_path / "adopted.toml"
