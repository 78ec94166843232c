"""`station apply`: every form that is read, every form that is written, and what is reported with it."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from station.files.calibrated_sample_writers import WRITERS
from station.sending.to_foxglove import CalibratedSample
from tests.station.applying.independent import drawn_std, evaluated
from tests.station.applying.inputs import (
    COLUMNS,
    COUNTS,
    EFFECTS,
    NAMES,
    PERIOD,
    T_S,
    TEMP,
    VOLTS,
    N,
    calibration_file,
    document,
    write_campaign,
    write_compressed,
    write_csv,
    write_mat,
    write_mcap,
    write_npz,
    write_parquet,
)  # fmt: skip
from tests.station.applying.run import OUTPUTS, apply, written
from tests.station.calibrated.test_calibration_applied import effect

FORMS: dict[str, Callable[[Path], Path]] = {
    "a.csv": write_csv, "a.npz": write_npz, "b.npz": write_compressed, "a.parquet": write_parquet,
    "a.mat": write_mat, "a.mcap": write_mcap, "campaign": write_campaign,
}  # fmt: skip


@pytest.fixture(scope="module")
def by_hand() -> tuple[np.ndarray, ...]:
    """What the equations say, slowly: not while the tests are collected, by each worker."""
    return evaluated(document(*EFFECTS), COUNTS / PERIOD, T_S, TEMP)


@pytest.mark.parametrize("form", FORMS)
def test_from_every_form_it_is_what_the_equations_say(
    tmp_path: Path, form: str, by_hand: tuple[np.ndarray, ...]
) -> None:
    known, source, out = calibration_file(tmp_path, *EFFECTS), FORMS[form](tmp_path / form), tmp_path / "o.npz"
    result = apply(source, "--calibration", known, "--out", out)
    assert result.exit_code == 0, result.output + repr(result.exception)
    found = written(out)
    assert found[:, :3] == pytest.approx(by_hand[0], rel=1e-12, abs=1e-12)
    assert found[:, 3:] == pytest.approx(by_hand[1], rel=1e-12, abs=1e-12)
    with np.load(out) as arrays:
        assert np.array_equal(arrays["t_s"], T_S)
        assert np.array_equal(arrays["temp_c"], TEMP)
        assert form == "a.mcap" or np.array_equal(arrays["aux_volts"], VOLTS)
    sidecar = json.loads((tmp_path / "o.npz.json").read_text())
    assert sidecar["samples"] == N
    assert sidecar["period_s"] == pytest.approx(PERIOD, rel=1e-12)


def test_running_counts_become_increments(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path, *EFFECTS), write_campaign(tmp_path / "c", output="cumulative")
    result = apply(source, "--calibration", known, "--out", tmp_path / "o.npz")
    assert result.exit_code == 0, result.output + repr(result.exception)
    # the first row is the base of the others; the two files follow one another without a gap
    assert written(tmp_path / "o.npz").shape == (N - 1, 6)
    with np.load(tmp_path / "o.npz") as arrays:
        assert np.array_equal(arrays["t_s"], T_S[1:])
    bare = calibration_file(tmp_path)
    apply(source, "--calibration", bare, "--out", tmp_path / "p.npz")
    plain = evaluated(document(), COUNTS / PERIOD, T_S, TEMP)
    assert written(tmp_path / "p.npz") == pytest.approx(np.hstack(plain)[1:], rel=1e-12, abs=1e-12)


def test_frames_and_units(tmp_path: Path, by_hand: tuple[np.ndarray, ...]) -> None:
    known, source = calibration_file(tmp_path, *EFFECTS), write_campaign(tmp_path / "c")
    apply(source, "--calibration", known, "--out", tmp_path / "frd.npz", "--frame", "FRD")
    apply(source, "--calibration", known, "--out", tmp_path / "cube.npz", "--frame", "cube")
    f, omega = by_hand
    turned = np.hstack((f * [1, -1, -1], omega * [1, -1, -1]))  # x forward, y left, z up
    assert written(tmp_path / "frd.npz") == pytest.approx(turned, rel=1e-12, abs=1e-12)
    # IMU x points along cube +y, y along -x
    in_cube = np.hstack([np.column_stack((-part[:, 1], part[:, 0], part[:, 2])) for part in (f, omega)])
    assert written(tmp_path / "cube.npz") == pytest.approx(in_cube, rel=1e-12, abs=1e-12)
    result = apply(source, "--calibration", known, "--out", tmp_path / "g.npz", "--units", "g,deg/s")
    assert result.exit_code == 0
    with np.load(tmp_path / "g.npz") as arrays:
        assert arrays["f_z_g"] * 9.80665 == pytest.approx(f[:, 2], rel=1e-12)
        assert np.radians(arrays["omega_y_deg_s"]) == pytest.approx(omega[:, 1], rel=1e-12)


def test_the_sigma_is_that_of_the_calibrations_parameters(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path), write_npz(tmp_path / "a.npz")
    apply(source, "--calibration", known, "--out", tmp_path / "o.npz")
    sidecar = json.loads((tmp_path / "o.npz.json").read_text())
    assert sidecar["spans_s"] == [[T_S[0], T_S[2999]], [T_S[3000], T_S[-1]]]
    of_a_second = slice(0, 3000, 50)
    drawn = drawn_std(document(), COUNTS[of_a_second] / PERIOD, T_S[of_a_second], TEMP[of_a_second], draws=200)
    reported = [*sidecar["specific_force_std_m_s2"][0], *sidecar["angular_rate_std_rad_s"][0]]
    assert reported == pytest.approx(drawn, rel=4 / np.sqrt(2 * 200))


def _csv(path: Path) -> np.ndarray:
    return np.genfromtxt(path, delimiter=",", names=True)


def _parquet(path: Path) -> dict[str, np.ndarray]:
    import pyarrow.parquet as parquet

    return {name: column.to_numpy() for name, column in zip(*(lambda t: (t.column_names, t.columns))(
        parquet.read_table(path)), strict=True)}  # fmt: skip


def _mat(path: Path) -> dict[str, np.ndarray]:
    from scipy.io import loadmat

    return {name: value[:, 0] for name, value in loadmat(path).items() if not name.startswith("__")}


def _mcap(path: Path) -> dict[str, np.ndarray]:
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        rows = [(m.log_time, d) for _, c, m, d in reader.iter_decoded_messages() if c.topic == "/imu/calibrated"]
    assert [at for at, _ in rows] == np.rint(T_S * 1e9).astype(int).tolist()
    known = {
        name: np.array([getattr(one, name) for _, one in rows]) for name in [*OUTPUTS, "t_s", "temperature_c"]
    }
    fields = rows[0][1].DESCRIPTOR.fields  # in a file and live each has one number
    live = {field.name: field.number for field in CalibratedSample.DESCRIPTOR.fields}
    assert [field.name for field in fields if live.get(field.name) != field.number] == ["aux_volts"]
    return known | {"temp_c": known["temperature_c"]}


def _npz(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as arrays:
        return dict(arrays)


def _ros2(path: Path) -> dict[str, np.ndarray]:
    rosbags = pytest.importorskip("rosbags.highlevel")
    from rosbags.typesys import Stores, get_typestore

    found: dict[str, list[float]] = {name: [] for name in [*OUTPUTS, "t_s", "temp_c"]}
    with rosbags.AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, at, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            if connection.msgtype == "sensor_msgs/msg/Temperature":
                found["temp_c"].append(message.temperature)
                continue
            assert at == message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            assert message.orientation_covariance[0] == -1
            found["t_s"].append(round(at / 1e9, 9))
            for name, part in (("f", message.linear_acceleration), ("omega", message.angular_velocity)):
                for key in OUTPUTS:
                    if key.startswith(f"{name}_"):
                        found[key].append(getattr(part, key.split("_")[1]))
    return {name: np.array(values) for name, values in found.items()}


READERS = {".csv": _csv, ".parquet": _parquet, ".mat": _mat, ".mcap": _mcap, ".npz": _npz, ".ros2": _ros2}


@pytest.mark.parametrize("suffix", WRITERS)  # each has a reader of another library
def test_what_is_written_another_reader_reads_to_the_same_bits(tmp_path: Path, suffix: str) -> None:
    known, source, out = (
        calibration_file(tmp_path, *EFFECTS),
        write_npz(tmp_path / "a.npz"),
        tmp_path / f"o{suffix}",
    )
    result = apply(source, "--calibration", known, "--out", out)
    assert result.exit_code == 0, result.output + repr(result.exception)
    apply(source, "--calibration", known, "--out", tmp_path / "plain.npz")
    found, plain = READERS[suffix](out), _npz(tmp_path / "plain.npz")
    for name in [*OUTPUTS, "t_s", "temp_c"]:
        assert np.array_equal(found[name], plain[name]), name
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        {"a.npz", "calibration.json", out.name, f"{out.name}.json", "plain.npz", "plain.npz.json"}
    )


WITHOUT_T = {name: column for name, column in COLUMNS.items() if name != "temp_c"}
LAGS = effect("gyroscope.temperature_lag", x=3.0, y=-2.0, z=1.0, tau_s=30.0)


def test_without_an_effect_it_goes_on_and_says_so(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path, LAGS), write_csv(tmp_path / "a.csv", WITHOUT_T)
    result = apply(source, "--calibration", known, "--out", tmp_path / "o.npz", "--without", LAGS["name"])
    assert result.exit_code == 0, repr(result.exception)
    plain = np.hstack(evaluated(document(), COUNTS / PERIOD, T_S, TEMP))
    assert written(tmp_path / "o.npz") == pytest.approx(plain, rel=1e-12, abs=1e-12)
    assert json.loads((tmp_path / "o.npz.json").read_text())["effects"] == []


def test_what_is_interrupted_leaves_nothing(tmp_path: Path) -> None:
    from station.applying.applying import OutputRequest, Progress, apply_to
    from station.applying.open_source import open_source
    from station.calibration import load
    from station.files.logs.log_columns import ColumnOptions

    class Interrupted(Progress):
        def at(self, done: float, samples: int) -> None:
            raise KeyboardInterrupt

    known, source = load(calibration_file(tmp_path)), write_npz(tmp_path / "a.npz")
    for suffix in READERS:
        out = tmp_path / f"o{suffix}"
        with pytest.raises(KeyboardInterrupt):
            apply_to(open_source(source, ColumnOptions(), None), known, out, OutputRequest(), Interrupted())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "calibration.json"]


def test_warnings_of_every_block_are_reported_with_counts(tmp_path: Path) -> None:
    n = 40_000  # more than two blocks
    temp = np.full(n, np.nan)
    temp[-100:] = 60.0  # nothing before
    zeros = dict.fromkeys(NAMES, np.zeros(n)) | {"az": np.full(n, 2020.0)}
    columns = {"t_s": PERIOD * np.arange(1, n + 1), **zeros, "temp_c": temp}
    lags = effect("accelerometer.temperature_lag", x=1e-5, tau_s=40.0)
    known, source = calibration_file(tmp_path, lags), write_npz(tmp_path / "a.npz", columns)
    result = apply(source, "--calibration", known, "--out", tmp_path / "o.npz")
    assert result.exit_code == 0, repr(result.exception)
    lag, outside, missing = json.loads((tmp_path / "o.npz.json").read_text())["warnings"]
    assert "32768 of 40000 samples" in lag
    assert "250 ug" in lag
    assert "60.0 to 60.0 degC" in outside
    assert "100 of 40000 samples" in outside
    assert "39900 samples" in missing


def test_the_document_next_to_it_says_of_what_and_by_what_it_is(tmp_path: Path) -> None:
    from fixtures_db.hash_chain import canonical, digest

    source = write_campaign(tmp_path / "c")
    apply(source, "--calibration", calibration_file(tmp_path), "--out", tmp_path / "o.npz", "--frame", "cube")
    sidecar = json.loads((tmp_path / "o.npz.json").read_text())
    stored = json.loads((tmp_path / "calibration.json").read_text())
    assert sidecar["calibration"]["sha256"] == digest(canonical(stored))
    assert (sidecar["frame"], sidecar["axes"], sidecar["mounting"]) == ("cube", "+y,-x,+z", "+y,-x,+z")
    assert sidecar["software"].startswith("fog-station")
