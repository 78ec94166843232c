"""A bias that walks at random is told from wider noise and from a line, and is no sure name."""

from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.diagnose import diagnose
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign

SECONDS, RATE, BLOCK_S = 2000, 10, 100.0
WHITE = 3e-3  # g, of a sample
WALK = 1e-3  # g in an hour's root


def soak(folder: Path, accel: FloatArray, *, temperature: FloatArray | None = None) -> Campaign:
    """Return samples (n, 3) [g] at rest, read as a user's table is."""
    columns, names = [accel], "ax,ay,az"
    if temperature is not None:
        columns, names = [accel, temperature[:, None]], f"{names},temperature"
    np.savetxt(folder / "log.csv", np.hstack(columns), "%.9g", ",", header=names, comments="")
    options = ["--rate", str(RATE), "--unit-accel", "g", "--as", "soak", "--campaign", str(folder / "c")]
    assert cli.run(["diagnose", str(folder / "log.csv"), *options]) == 0
    return read_campaign(folder / "c").campaign


def noise(seed: int) -> FloatArray:
    return WHITE * np.random.default_rng(seed).standard_normal((SECONDS * RATE, 3))


def walk(seed: int, size: float = WALK) -> FloatArray:
    steps = np.random.default_rng(1000 + seed).standard_normal((SECONDS * RATE, 3))
    return np.cumsum(size / np.sqrt(3600 * RATE) * steps, axis=0)


def test_a_walk_is_found_of_its_size_foretells_better_and_is_no_sure_name(tmp_path: Path) -> None:
    found = diagnose([soak(tmp_path, noise(9) + walk(9))])
    (finding,) = (each for each in found.findings if each.effect == "accelerometer.bias_walk")
    assert abs(np.log(finding.value[0] / WALK)) < 3 * finding.std[0] / finding.value[0] < 1
    assert finding.confidence == "ambiguous"
    assert {"accelerometer.bias_drift", "accelerometer.bias_temperature"} == set(finding.aliases)
    assert finding.share > 0.5
    (error,) = (each for each in found.errors if each.quantity == "accelerometer soaks")
    assert error.held_out_after is not None
    assert error.held_out_before is not None
    assert error.held_out_after < 0.8 * error.held_out_before
    assert found.verdict == "unexplained"  # a walk has no cause
    assert not found.added  # it is in no calibration
