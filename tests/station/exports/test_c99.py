"""An exported program, compiled with every warning and sanitizer, does with counts what the station does."""

import hashlib
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.units import STANDARD_GRAVITY
from station import cli
from station.calibrated.applied_calibration import calibrated_inputs
from station.errors import DataRefused
from station.exports import EXPORTS, Request
from tests.refusals import refused
from tests.station.calibrated.test_calibration_applied import calibration, effect
from tests.station.exports.c_and_station import apart, by_library, random_samples
from tests.station.exports.c_program import FLAGS, Program, compiled, needs_compiler
from tests.station.exports.every_effect import DRIFT, EFFECTS, every_effect, with_facts

pytestmark = needs_compiler
LIMIT = {False: 1e-12, True: 1e-6}
both_numbers = pytest.mark.parametrize("is_float", [False, True], ids=["double", "float"])


def exported(folder: Path, document: dict[str, Any], *, is_float: bool = False) -> tuple[str, str]:
    (folder / "c.json").write_text(json.dumps(document))
    number = "--float" if is_float else "--double"
    assert cli.run(["export", str(folder / "c.json"), "--to", "c", number, "--out", str(folder)]) == 0
    return (folder / "fog_imu.h").read_text(), (folder / "fog_imu.c").read_text()


def program(
    folder: Path, document: dict[str, Any], *, is_float: bool = False, inputs: tuple[str, ...] = ()
) -> Program:
    exported(folder, document, is_float=is_float)
    return compiled(folder, "fog_imu", is_float=is_float, inputs=inputs)


@both_numbers
def test_with_every_effect_it_is_what_the_library_makes_of_the_counts(is_float: bool, tmp_path: Path) -> None:
    found = apart(every_effect(DRIFT), tmp_path, random_samples(4000, 4), is_float=is_float)
    assert max(found.force, found.rate, found.self_test) < LIMIT[is_float]


def test_each_effect_is_in_it() -> None:
    """Else one that is left out would not show above."""
    samples = random_samples(3000, 4)
    whole = by_library(every_effect(), samples)
    for i, one in enumerate(EFFECTS):
        others = [*EFFECTS[:i], *EFFECTS[i + 1 :]]
        less = by_library({**every_effect(), "effects": others}, samples)
        assert max(np.abs(a - b).max() for a, b in zip(whole, less, strict=True)) > 1e-7, one["name"]


def test_float_loses_no_small_step_of_a_lag(tmp_path: Path) -> None:
    known = with_facts(calibration(effect("accelerometer.temperature_lag", x=1e-2, y=0.0, z=0.0, tau_s=600.0)))
    known["accelerometer"] |= {"bias": {"value": [0.0] * 3}, "misalignment": {"value": np.eye(3).tolist()}}
    n, dt = 200_000, 1 / 2048
    T = np.full(n, 26.0)
    T[0] = 25.0
    found = program(tmp_path, known, is_float=True).apply(np.zeros((n, 6)), T, np.full(n, dt))
    behind = 1 - np.exp(-dt * (n - 1.5) / 600)  # the step is a ramp of one sample: half of it is lost
    assert -found[-1, 0] / STANDARD_GRAVITY / 1e-2 == pytest.approx(behind, rel=1e-5)


def test_the_header_says_what_it_is(tmp_path: Path) -> None:
    header, _ = exported(tmp_path, every_effect(DRIFT))
    digest = hashlib.sha256((tmp_path / "c.json").read_bytes()).hexdigest()
    for reported in (
        "Calibration of FOG-3 S7", f"SHA-256 of c.json: {digest}", "accepted 2026-03-04T12:00:00Z",
        "until 2027-03-04T00:00:00Z", "5.0 to 45.0 degC", "NOT CARRIED: accelerometer.bias_drift",
    ):  # fmt: skip
        assert reported in header
    for one in EFFECTS:
        assert f" *   {one['name']}\n" in header


def test_the_residual_of_its_rounds_is_what_it_says(tmp_path: Path) -> None:
    bent = effect("gyroscope.sagnac_sine", x=4e-3, y=4e-3, z=4e-3)
    known = with_facts(calibration(bent))
    header, source = exported(tmp_path, known, is_float=True)
    reported = re.search(
        r"Rounds: (\S+) of the input's length is left after (\d+) rounds, up to 5 g and (\d+)", header
    )
    assert reported is not None
    assert float(reported[3]) == 200  # 0.8 rad / 4e-3
    assert float(reported[1]) < 3e-8
    few = source.replace(f"round < {reported[2]};", "round < 4;")
    assert few != source
    (tmp_path / "fog_imu.c").write_text(few)
    ran = compiled(tmp_path, "fog_imu", is_float=True)
    rate = np.array([[150.0, -150, 150, 0, 0, 0]])
    counts = np.round(np.sin(4e-3 * rate) / 4e-3 * 36000)
    exact = calibrated_inputs(known, counts[:, 3:], counts[:, :3]).omega
    assert exact is not None
    off = np.degrees(ran.apply(counts, np.array([25.0]), np.ones(1))[0, 3:]) - exact[0]
    assert np.abs(off).max() > 1e-3  # four rounds are too few, as the number says


def test_the_self_test_notices_a_number_that_was_changed(tmp_path: Path) -> None:
    _, source = exported(tmp_path, every_effect())
    changed = re.sub(r"(accel_k\[3\] = \{ 1010\.0)", r"\g<1>001", source)
    assert changed != source
    (tmp_path / "fog_imu.c").write_text(changed)
    assert compiled(tmp_path, "fog_imu", is_float=False).self_test() > 1e-9


@pytest.mark.parametrize(("there", "nan"), [("accelerometer", slice(3, 6)), ("gyroscope", slice(0, 3))])
def test_a_triad_that_is_not_calibrated_is_no_number(there: str, nan: slice, tmp_path: Path) -> None:
    g, drift = effect("gyroscope.g_sensitivity", xx=1.0), effect(f"{there}.temperature_rate", x=1.0)
    other = {"accelerometer": "gyroscope", "gyroscope": "accelerometer"}[there]
    document = with_facts(calibration(g, drift))
    del document[other]
    ran = program(tmp_path, document)
    found = ran.apply(np.ones((3, 6)), np.arange(3.0), np.ones(3))
    assert np.isnan(found[:, nan]).all()
    assert np.isfinite(found).sum() == 9
    assert ran.self_test() < 1e-12
    assert f"gyroscope.g_sensitivity: there is no calibrated {other}" in (tmp_path / "fog_imu.h").read_text()


def test_a_temperature_that_is_no_number_changes_nothing(tmp_path: Path) -> None:
    known = with_facts(calibration(effect("accelerometer.bias_temperature", x=1e-3)))
    known["accelerometer"] |= {"bias": {"value": [0.0] * 3}, "misalignment": {"value": np.eye(3).tolist()}}
    T = np.array([np.nan, 35.0, np.nan, np.inf, -1e9, 15.0])
    found = program(tmp_path, known).apply(np.zeros((6, 6)), T, np.ones(6))
    expected = np.array([0.0, -10.0, -10.0, -10.0, -10.0, 10.0]) * 1e-3 * STANDARD_GRAVITY
    assert found[:, 0] == pytest.approx(expected, abs=1e-15)


TERMS = (
    "-u * exp(-(u / w)**4)",
    "lag(T, tau) * sin(2 * pi * u / w)",
    "min(abs(u), w) * sign(f_2) * omega_norm / w",
)


@both_numbers
@pytest.mark.parametrize("term", TERMS)
def test_an_effect_of_ones_own_is_carried(term: str, is_float: bool, tmp_path: Path) -> None:
    text = (
        f'format = "effect/1"\nname = "own"\ntriad = "gyroscope"\nterm = "{term}"\nplausible = 1\nsource = "x"\n'
    )
    unit = "deg/h/K" if "lag" in term else "1"
    text += f'unit = "{unit}"\nshape.w = {{unit = "deg/s", low = 1, high = 1e3}}\n'
    values = {"x": 0.1, "y": -0.2, "z": 0.05, "w": 300.0}
    if "tau" in term:
        text, values["tau"] = text + 'shape.tau = {unit = "min", low = 1, high = 60}\n', 7.0
    entry = effect("gyroscope.own", **values)
    entry |= {"definition": text, "sha256": hashlib.sha256(text.encode()).hexdigest(), "unit": unit}
    document, samples = with_facts(calibration(entry)), random_samples(500, 2)
    ran = program(tmp_path, document, is_float=is_float)
    found = ran.apply(samples.counts, samples.T, samples.dt)
    rate = by_library(document, samples)[1]
    bare = by_library(with_facts(calibration()), samples)[1]
    size = np.linalg.norm(rate, axis=1)
    assert (np.linalg.norm(found[:, 3:] - rate, axis=1) / size).max() < LIMIT[is_float]
    assert (np.linalg.norm(bare - rate, axis=1) / size).max() > 1e-6
    assert ran.self_test() < LIMIT[is_float]


def test_each_effect_alone_compiles_without_a_warning_and_as_cpp_includes(tmp_path: Path) -> None:
    """What one effect does not need is not there: a variable that nobody uses would be a warning."""
    flags = [flag for flag in FLAGS if not flag.startswith("-O")]
    for i, one in enumerate(EFFECTS[::3]):
        exported(tmp_path, with_facts(calibration(one)), is_float=i % 2 == 1)
        command = ["cc", *flags, "-O2", "-Wmissing-prototypes", "-c", "fog_imu.c"]
        ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, (one["name"], ran.stderr)
    (tmp_path / "use.cpp").write_text('#include "fog_imu.h"\nint main() { return fog_imu_self_test() > 1e-6; }\n')
    if shutil.which("c++"):
        subprocess.run(
            ["c++", "-Wall", "-Werror", "use.cpp", "fog_imu.o", "-lm", "-o", "use"], cwd=tmp_path, check=True
        )
        subprocess.run([tmp_path / "use"], check=True)


def test_words_of_a_file_end_no_comment(tmp_path: Path) -> None:
    nasty = "*/ int x; /* ??/\n#error \\"
    header, _ = exported(tmp_path, {**every_effect(), "serial": nasty, "software": nasty})
    assert "#error" not in [line.strip() for line in header.splitlines()]
    assert compiled(tmp_path, "fog_imu", is_float=False).self_test() < 1e-12


@pytest.mark.parametrize(
    ("changed", "reported"),
    [
        ({"accelerometer": {"scale_factor": {"value": [0.0, 1, 1]}}}, "scale_factor"),
        ({"accelerometer": {"bias": {"value": [float("nan"), 1, 1]}}}, "accelerometer.bias"),
        ({"accelerometer": {"misalignment": {"value": [[1, 1, 1]] * 3}}}, "singular"),
        ({"effects": [effect("accelerometer.cubic", x=float("inf"))]}, "accelerometer.cubic"),
        ({"effects": [effect("accelerometer.cubic", x=10**400)]}, "accelerometer.cubic"),
        ({"gyroscope": {"scale_factor": {"value": [1e-320, 1, 1]}}}, "gyroscope.scale_factor"),
        ({"effects": [{"name": "accelerometer.cubic"}]}, "'accelerometer.cubic'"),
        ({"effects": "cubic"}, "effects"), ({"temperature_range_c": [1.0]}, "temperature_range_c"),
        ({"effects": [effect("accelerometer.cubic", x=1e20)]}, "do not converge"),
    ],
)  # fmt: skip
def test_what_is_no_calibration_is_refused_and_nothing_written(
    changed: dict[str, Any], reported: str, tmp_path: Path
) -> None:
    document = every_effect()
    for key, value in changed.items():
        document[key] = {**document[key], **value} if isinstance(value, dict) else value
    (tmp_path / "c.json").write_text(json.dumps(document))
    with refused(DataRefused, None, reported):
        next(one for one in EXPORTS if one.name == "c").files(Request(tmp_path / "c.json"))


@pytest.mark.parametrize("out", ["int.c", "my-imu.c", "x.txt", "no/where/imu.c", "c.json"])
def test_a_place_that_cannot_be_is_refused_and_nothing_written(out: str, tmp_path: Path) -> None:
    (tmp_path / "c.json").write_text(json.dumps(every_effect()))
    assert cli.run(["export", str(tmp_path / "c.json"), "--to", "c", "--out", str(tmp_path / out)]) != 0
    assert [each.name for each in tmp_path.iterdir()] == ["c.json"]
    assert json.loads((tmp_path / "c.json").read_text())["format"] == "calibration/1"
