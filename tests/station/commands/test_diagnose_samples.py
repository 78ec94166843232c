"""``station diagnose LOG`` of a gyroscope that errs by the phase of a ramp: JSON, text and page."""

import json
from pathlib import Path

import numpy as np
import pytest

from station import cli

N, PERIOD = 30_000, 0.02


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng, t = np.random.default_rng(1), PERIOD * np.arange(1, N + 1)
    ramp = (0.24 * t + 2e-3 * np.cumsum(rng.normal(size=N))) % 1.0
    gyro = 0.02 * rng.normal(size=N) + 0.006 * np.cos(2 * np.pi * ramp)
    file = tmp_path_factory.mktemp("log") / "fog.csv"
    np.savetxt(
        file, np.stack((t, gyro, 5 * ramp), axis=1), "%.8g", ",", header="t,wz_deg_s,ramp", comments=""
    )  # fmt: skip
    return file


def test_an_error_by_the_phase_of_a_ramp_is_told_with_its_share_and_drawn_by_the_phase(
    log: Path, tmp_path: Path
) -> None:
    out, page = tmp_path / "out.json", tmp_path / "out.html"
    assert cli.run(["diagnose", str(log), "--aux", "ramp", "--json", str(out), "--html", str(page)]) == 0
    document = json.loads(out.read_text())
    (finding,) = document["findings"]
    assert (finding["effect"], finding["confidence"]) == ("auxiliary.periodic", "established")
    cosine = finding["coefficients"]["gz.cos1"]
    assert abs(cosine["value"] - 0.006 * 3600) < 4 * cosine["std"]
    assert finding["unit"] == "deg/h"
    assert finding["share"] == pytest.approx(0.043, abs=0.005)  # 0.006^2 / 2 of 0.02^2 + 0.006^2 / 2
    (channel,) = document["noise"]
    assert channel["channel"] == "gyroscope z"
    samples = next(each for each in document["error"] if each["quantity"] == "gyroscope samples")
    assert samples["held_out_after"] < samples["held_out_before"]
    assert "phase of ramp mod" in page.read_text()
