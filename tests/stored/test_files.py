"""What is read of files: a campaign folder of counts, logs of text and of arrays, a fusion folder."""

from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.campaign.plan_steps import turn_steps
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.fusion_folder import read_fusion
from station.files.logs.log_campaign import LogOptions, campaign_of_logs
from station.files.logs.log_campaign import write_campaign as write_logs
from station.files.logs.log_columns import ColumnOptions
from tests.procedures.diagnosis.planted import with_reference_time
from tests.station.campaign_writing import write_campaign
from tests.station.files.fusion_folder.drive_folders import write_folder
from tests.stored.conftest import StoredResult
from tests.stored.small_campaigns import unit

PERIOD = 0.02
VOLATILE = ("sha256", "folder", "path", "file")


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
def test_a_campaign_folder(stored_result: StoredResult, tmp_path: Path, suffix: str) -> None:
    truth = unit(2)
    bench = simulate_campaign(truth, 2, dwell_s=5.0, positions=(1, 3, 5), turns=turn_steps(1, 1.0)[:2],
                              certificate_sigma=5e-6, repeats=0)  # fmt: skip
    campaign = with_reference_time(bench, 300.0, 2) if suffix == ".csv" else bench
    write_campaign(tmp_path / "c", campaign, truth.sample_period_s, suffix)
    stored_result.check(read_campaign(tmp_path / "c").campaign)


def log_columns(n: int = 1500) -> dict[str, np.ndarray]:
    """Rest, a turn about z of 90 deg/s, rest: deg/s, g, kelvin; the time in ms."""
    rng, i = np.random.default_rng(1), np.arange(1, n + 1)
    turning = (i > 500) & (i <= 1000)
    gyro = 0.01 * rng.standard_normal((n, 3)) + 90.0 * turning[:, None] * [0, 0, 1]
    accel = np.array([0.01, -0.02, 1.0]) + 1e-3 * rng.standard_normal((n, 3))
    columns = {"time_ms": 1000 * PERIOD * i, **{f"gyro_{a}": gyro[:, k] for k, a in enumerate("xyz")}}
    columns |= {f"acc_{a}": accel[:, k] for k, a in enumerate("xyz")}
    return columns | {"temperature_K": 298.15 + i / 600, "fan": i % 7.0}


def text_of(columns: dict[str, np.ndarray], comma: str = ",", *, header: bool = True) -> str:
    rows = (comma.join(f"{value:.9g}" for value in row) for row in zip(*columns.values(), strict=True))
    return "\n".join(([comma.join(columns)] if header else []) + list(rows)) + "\n"


LOGS = {
    "commas": ("a.csv", lambda c: text_of(c), ColumnOptions(unit_gyro="dps", auxiliary=("fan",))),
    "semicolons": ("a.csv", lambda c: text_of(c, ";"), ColumnOptions()),
    "tabs, no header": (
        "a.txt", lambda c: text_of(c, "\t", header=False),
        ColumnOptions(gyro=("2", "3", "4"), accel=("5", "6", "7"), time="1", unit_time="ms", unit_gyro="dps"),
    ),
    "no time": (
        "a.csv", lambda c: text_of({k: v for k, v in c.items() if k != "time_ms"}),
        ColumnOptions(rate_hz=50.0, unit_gyro="rad/s"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LOGS)
def test_a_log_of_text(stored_result: StoredResult, tmp_path: Path, name: str) -> None:
    file, text, columns = LOGS[name]
    (tmp_path / file).write_text(text(log_columns()))
    found = campaign_of_logs([tmp_path / file], LogOptions(columns, latitude_deg=48.1, serial="7"))
    write_logs(tmp_path / "c", found)
    read = read_campaign(tmp_path / "c").campaign
    stored_result.check({"read": read, "guesses": len(found.guesses), "notes": len(found.notes)})


@pytest.mark.parametrize("ends", [".npz", ".mat", ".parquet"])
def test_a_log_of_arrays(stored_result: StoredResult, tmp_path: Path, ends: str) -> None:
    columns, file = log_columns(800), tmp_path / f"a{ends}"
    if ends == ".npz":
        stacked = {"t": columns["time_ms"] / 1000}
        stacked |= {
            "gyro": np.stack([columns[f"gyro_{a}"] for a in "xyz"]),
            "acc": np.stack([columns[f"acc_{a}"] for a in "xyz"]),
        }
        np.savez(file, **stacked)
    elif ends == ".mat":
        pytest.importorskip("scipy.io").savemat(file, {name: value[:, None] for name, value in columns.items()})
    else:
        arrow = pytest.importorskip("pyarrow")
        pytest.importorskip("pyarrow.parquet").write_table(arrow.table(columns), file)
    found = campaign_of_logs([file], LogOptions(ColumnOptions(unit_gyro="dps")))
    stored_result.check(found.loaded.campaign)


def test_a_fusion_folder(stored_result: StoredResult, tmp_path: Path) -> None:
    folder = write_folder(tmp_path, 5.0)
    stored_result.check(read_fusion(folder), without=VOLATILE)
