"""`station apply`: every form that is read, every form that is written, and what is refused."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from station.cli import app
from station.exit_codes import explain
from tests.station.applying.independent import evaluated
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
from tests.station.calibrated.test_calibration_applied import effect

OUTPUTS = [f"{name}_{axis}_{unit}" for name, unit in (("f", "m_s2"), ("omega", "rad_s")) for axis in "xyz"]
FORMS: dict[str, Callable[[Path], Path]] = {
    "a.csv": write_csv, "a.npz": write_npz, "b.npz": write_compressed, "a.parquet": write_parquet,
    "a.mat": write_mat, "a.mcap": write_mcap, "campaign": write_campaign,
}  # fmt: skip
BY_HAND = evaluated(document(*EFFECTS), COUNTS / PERIOD, T_S, TEMP)


def apply(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["apply", *map(str, arguments)])


def written(path: Path) -> np.ndarray:
    with np.load(path) as arrays:
        return np.column_stack([arrays[name] for name in OUTPUTS])


def refused(result: Result) -> str:
    code, line = explain(result.exception) if result.exception else (result.exit_code, result.output)
    assert code == 3, line
    assert "\n" not in line.strip()
    return line


@pytest.mark.parametrize("form", FORMS)
def test_from_every_form_it_is_what_the_equations_say(tmp_path: Path, form: str) -> None:
    known, source, out = calibration_file(tmp_path, *EFFECTS), FORMS[form](tmp_path / form), tmp_path / "o.npz"
    result = apply(source, "--calibration", known, "--out", out)
    assert result.exit_code == 0, result.output + repr(result.exception)
    found = written(out)
    assert found[:, :3] == pytest.approx(BY_HAND[0], rel=1e-12, abs=1e-12)
    assert found[:, 3:] == pytest.approx(BY_HAND[1], rel=1e-12, abs=1e-12)
    with np.load(out) as arrays:
        assert np.array_equal(arrays["t_s"], T_S)
        assert np.array_equal(arrays["temp_c"], TEMP)
        assert form == "a.mcap" or np.array_equal(arrays["aux_volts"], VOLTS)
    beside = json.loads((tmp_path / "o.npz.json").read_text())
    assert beside["samples"] == N
    assert beside["period_s"] == pytest.approx(PERIOD, rel=1e-12)


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


def test_frames_and_units(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path, *EFFECTS), write_campaign(tmp_path / "c")
    apply(source, "--calibration", known, "--out", tmp_path / "frd.npz", "--frame", "FRD")
    apply(source, "--calibration", known, "--out", tmp_path / "cube.npz", "--frame", "cube")
    f, omega = BY_HAND
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
    beside = json.loads((tmp_path / "o.npz.json").read_text())
    assert beside["spans_s"] == [[T_S[0], T_S[2999]], [T_S[3000], T_S[-1]]]
    # by drawing calibrations: parameters within their sigma, independent, of one second's samples
    draw, parts = np.random.default_rng(2), []
    t, rates, T = T_S[:3000:50], COUNTS[:3000:50] / PERIOD, TEMP[:3000:50]
    truth = np.hstack(evaluated(document(), rates, t, T))
    for _ in range(400):
        other = document()
        for name in ("accelerometer", "gyroscope"):
            for part in other[name].values():
                part["value"] = (
                    np.array(part["value"]) + draw.normal(0, 1, np.shape(part["value"])) * part["std"]
                ).tolist()
        parts.append(np.hstack(evaluated(other, rates, t, T)) - truth)
    drawn = np.sqrt(np.mean(np.square(parts), axis=(0, 1)))
    said = [*beside["specific_force_std_m_s2"][0], *beside["angular_rate_std_rad_s"][0]]
    assert said == pytest.approx(drawn, rel=4 / np.sqrt(2 * 400))


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
    return {name: np.array([getattr(one, name) for _, one in rows]) for name in [*OUTPUTS, "t_s", "temp_c"]}


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


@pytest.mark.parametrize("suffix", READERS)
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


def test_every_writer_has_a_foreign_reader() -> None:
    from station.files.sample_files import WRITERS

    assert set(READERS) == set(WRITERS)


WITHOUT_T = {name: column for name, column in COLUMNS.items() if name != "temp_c"}
BACK = dict(COLUMNS, t_s=np.concatenate((T_S[:3000], T_S[3000:] - 20)))
FRACTIONS = dict(COLUMNS, gy=COUNTS[:, 1] + np.where(np.arange(N) == 4000, 0.25, 0.0))
PER_SECOND = COLUMNS | {name: np.rint(column / PERIOD) for name, column in COLUMNS.items() if name in NAMES}
BY_UNIT = {name if name not in NAMES[:3] else f"{name} [deg/s]": column for name, column in COLUMNS.items()}
LAGS = effect("gyroscope.temperature_lag", x=3.0, y=-2.0, z=1.0, tau_s=30.0)
NO_ACCEL = {name: column for name, column in COLUMNS.items() if name not in NAMES[3:]}
SENSITIVE = effect("gyroscope.g_sensitivity", xz=0.7, yy=-0.3)
HUGE = effect("accelerometer.quadratic", x=-0.9, y=2.0, z=2.0)


@pytest.mark.parametrize(
    ("columns", "effects", "options", "said"),
    [
        (COLUMNS, (), ("--serial", "S2"), "found serial S2, expected S1, which the calibration is of"),
        (WITHOUT_T, (LAGS,), (), r"gyroscope.temperature_lag (up to 75 deg/h)"),
        (NO_ACCEL, (SENSITIVE,), (), r"gyroscope.g_sensitivity (up to 0.7 deg/h)"),
        (BACK, (), (), ":3002: found time 45.02 after 65, expected times that rise"),
        (FRACTIONS, (), (), ":4002: found "),
        (PER_SECOND, (), (), "in the middle: outputs in a second, expected counts of a sample"),
        (BY_UNIT, (), (), "found rates in deg/s, expected counts, which the calibration is of"),
        (COLUMNS, (), ("--time", "t_s", "--rate", "51"), "50 Hz by the times, +2.0% of the period"),
        (COLUMNS, (), ("--rate", "51"), "50 rows a second by column t_s, expected --rate 51 within 1 %"),
        (COLUMNS, (HUGE,), (), "accelerometer.quadratic not to settle in "),
        (COLUMNS, (), ("--gyro", "wx,wy,wz"), "no column 'wx'"),
        (COLUMNS, (), ("--without", "gyroscope.moonlight"), "no effect gyroscope.moonlight"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_and_nothing_is_written(
    tmp_path: Path, columns: dict[str, np.ndarray], effects: tuple[dict[str, object], ...],
    options: tuple[str, ...], said: str,
) -> None:  # fmt: skip
    known, source = calibration_file(tmp_path, *effects), write_csv(tmp_path / "a.csv", columns)
    line = refused(apply(source, "--calibration", known, "--out", tmp_path / "o.csv", *options))
    assert said in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "calibration.json"]


def test_a_calibration_of_rates_refuses_counts(tmp_path: Path) -> None:
    known = calibration_file(tmp_path, unit="output")
    line = refused(apply(write_campaign(tmp_path / "c"), "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "found counts (increments), expected rates, which the calibration is of" in line
    line = refused(apply(write_npz(tmp_path / "a.npz"), "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "g in the middle: counts of a sample, expected rates" in line
    rates = {name: column / PERIOD if name in NAMES else column for name, column in COLUMNS.items()}
    result = apply(write_npz(tmp_path / "r.npz", rates), "--calibration", known, "--out", tmp_path / "o.npz")
    assert result.exit_code == 0, repr(result.exception)
    plain = np.hstack(evaluated(document(), COUNTS / PERIOD, T_S, TEMP))
    assert written(tmp_path / "o.npz") == pytest.approx(plain, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("names", "options", "said"),
    [
        ("{} [rad/s]", (), "gyroscope in rad/s, 0.01745 outputs in 1 deg/s, expected 3.593e+05 outputs"),
        ("{}_deg_s", (), "gyroscope in deg/s, 1 outputs in 1 deg/s"),
        ("{}", ("--unit-gyro", "deg/h"), "gyroscope in deg/h, 3600 outputs in 1 deg/s"),
    ],
)
def test_rates_in_another_unit_than_the_calibrations_are_refused(
    tmp_path: Path, names: str, options: tuple[str, ...], said: str
) -> None:
    known = calibration_file(tmp_path, unit="output")
    columns = {names.format(n) if n in NAMES[:3] else n: c for n, c in COLUMNS.items()}
    told = ("--gyro", ",".join(map(names.format, NAMES[:3])), *options)
    asked = ("--calibration", known, "--out", tmp_path / "o.npz", *told)
    assert said in refused(apply(write_csv(tmp_path / "a.csv", columns), *asked))


def test_an_archive_that_is_damaged_further_on_is_refused(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path), write_npz(tmp_path / "a.npz")
    content = bytearray(source.read_bytes())
    content[len(content) // 2] ^= 0xFF
    source.write_bytes(content)
    line = refused(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "a.npz" in line
    assert not (tmp_path / "o.npz").exists()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"effects": None}, "expected a list of effects"),
        ({"temperature_range_c": "warm"}, "temperature_range_c 'warm', expected two numbers"),
        ({"valid_until": "2027-01-01"}, "valid_until '2027-01-01', expected a time with its zone"),
        ({"accepted_utc": 7}, "accepted_utc 7, expected a time with its zone"),
    ],
)
def test_a_calibration_with_something_else_in_it_is_refused(
    tmp_path: Path, more: dict[str, object], said: str
) -> None:
    known, source = calibration_file(tmp_path, **more), write_npz(tmp_path / "a.npz")
    assert said in refused(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))


def test_what_is_read_is_never_written_over(tmp_path: Path) -> None:
    folder, known = write_campaign(tmp_path / "c"), calibration_file(tmp_path)
    step = next(path for path in folder.iterdir() if path.suffix in {".csv", ".mcap"})
    before = {path: path.read_bytes() for path in (*folder.iterdir(), known)}
    for out in (step, folder / f"{step.stem}.csv"):
        result = apply(folder, "--calibration", known, "--out", out)
        assert result.exception is not None or out not in before
        assert out not in before or "would be lost" in str(result.exception)
    assert all(path.read_bytes() == content for path, content in before.items())


def test_an_expired_calibration_is_applied_and_said_to_be(tmp_path: Path) -> None:
    known = calibration_file(tmp_path, valid_until="2020-01-02T00:00:00Z")
    result = apply(write_csv(tmp_path / "a.csv"), "--calibration", known, "--out", tmp_path / "o.csv")
    assert result.exit_code == 0, repr(result.exception)
    assert json.loads((tmp_path / "o.csv.json").read_text())["warnings"] == ["it expired on 2020-01-02"]


def test_a_campaign_of_another_period_or_unit_is_refused(tmp_path: Path) -> None:
    known = calibration_file(tmp_path)
    slow = write_campaign(tmp_path / "slow", period=0.0203)
    line = refused(apply(slow, "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "expected 49.2611 Hz as is stated, within 1 %" in line
    other = write_campaign(tmp_path / "other", serial="S9")
    assert "found serial S9" in refused(apply(other, "--calibration", known, "--out", tmp_path / "o.npz"))


def test_without_an_effect_it_goes_on_and_says_so(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path, LAGS), write_csv(tmp_path / "a.csv", WITHOUT_T)
    result = apply(source, "--calibration", known, "--out", tmp_path / "o.npz", "--without", LAGS["name"])
    assert result.exit_code == 0, repr(result.exception)
    plain = np.hstack(evaluated(document(), COUNTS / PERIOD, T_S, TEMP))
    assert written(tmp_path / "o.npz") == pytest.approx(plain, rel=1e-12, abs=1e-12)
    assert json.loads((tmp_path / "o.npz.json").read_text())["effects"] == []


def test_a_mat_above_2_gb_and_an_unknown_suffix_are_refused(tmp_path: Path) -> None:
    from station.errors import DataRefused
    from station.files.sample_files import WRITERS
    from station.files.sample_files.sample_file import SampleColumns

    with pytest.raises(DataRefused, match=r"2\.4 GB of samples, expected at most 2 GB"):
        WRITERS[".mat"](tmp_path / "o.mat", SampleColumns(("a",) * 8, 37_500_000, "sensor", True))
    known, source = calibration_file(tmp_path), write_npz(tmp_path / "a.npz")
    assert "found suffix '.xls', expected one of" in refused(
        apply(source, "--calibration", known, "--out", tmp_path / "o.xls")
    )
    assert list(tmp_path.glob("o.*")) == []


def test_what_is_interrupted_leaves_nothing(tmp_path: Path) -> None:
    from station.applying.applying import Asked, apply_to
    from station.applying.opened_source import open_source
    from station.applying.progress import Progress
    from station.calibration import load
    from station.files.logs.log_columns import ToldColumns

    class Interrupted(Progress):
        def at(self, done: float, samples: int) -> None:
            raise KeyboardInterrupt

    known, source = load(calibration_file(tmp_path)), write_npz(tmp_path / "a.npz")
    for suffix in READERS:
        out = tmp_path / f"o{suffix}"
        with pytest.raises(KeyboardInterrupt):
            apply_to(open_source(source, ToldColumns(), None), known, out, Asked(), Interrupted())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "calibration.json"]


def test_the_time_left_is_said_on_the_way() -> None:
    from station.applying.progress import Progress

    said, now = list[str](), [0.0]
    progress = Progress(said.append, lambda: now[0])
    for i in range(1, 41):
        now[0] = float(i)
        progress.at(i / 40, 1000 * i)
    assert said[0] == "5 %, 2000 samples, 38 s left"
    assert len(said) == 4  # a line every ten seconds
