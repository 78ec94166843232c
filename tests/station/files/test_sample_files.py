"""Each format of calibrated samples, read back by its own library, bit for bit, with what else the file says."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.calibrated_sample_writers import WRITERS, MatSamples, SampleColumns, writer_for
from tests.refusals import refused

NAMES = (
    "t_s",
    "ax",
    "ay",
    "az",
    "gx",
    "gy",
    "gz",
    "temp_c",
    "a_name_of_more_than_sixty_three_characters_" + "x" * 30,
)
NAN = float("nan")
ROWS = np.array([
    [0.0, 1.1, 2.2, 3.3, 4.4, 5.5, 6.6, 21.5, 1e-300],
    [0.02, -1.1, NAN, 3.3, 4.4, 5.5, 6.6, NAN, 0.1 + 0.2],
    [12.345678901, 0.1, 0.2, 0.3, NAN, NAN, NAN, 22.0, -5.0],
    [13.0, NAN, NAN, NAN, 0.4, 0.5, 0.6, 22.5, 6.0],
])  # fmt: skip


def written(path: Path, *, names: tuple[str, ...] = NAMES, is_si: bool = True) -> Path:
    """Write the rows in two parts."""
    writer = writer_for(path)(path, SampleColumns(names, 4, "housing", is_si=is_si))
    some = [column for name, column in zip(NAMES, ROWS.T, strict=True) if name in names]
    for part in (slice(0, 3), slice(3, 4)):
        writer.write([column[part].copy() for column in some])
    writer.finish()
    return path


def same(found: Any, column: int) -> bool:
    return np.array_equal(np.asarray(found, dtype=float).ravel(), ROWS[:, column], equal_nan=True)


def test_csv_has_numbers_that_read_back_to_the_same_bits_and_nothing_where_there_is_none(tmp_path: Path) -> None:
    lines = written(tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == ",".join(NAMES)
    assert lines[2] == "0.02,-1.1,,3.3,4.4,5.5,6.6,,0.30000000000000004"
    assert len(lines) == 5
    assert written(tmp_path / "b.csv").read_text().endswith("\n")


def test_parquet_has_doubles_nulls_and_no_dictionary(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    file = parquet.ParquetFile(written(tmp_path / "a.parquet"))
    table = file.read()
    assert table.column_names == list(NAMES)
    assert all(same(table[name].to_numpy(), i) for i, name in enumerate(NAMES))
    assert table["ay"].null_count == 2
    assert file.metadata.num_row_groups == 1
    column = file.metadata.row_group(0).column(1)
    assert column.compression == "SNAPPY"
    assert not any("DICTIONARY" in each for each in column.encodings)


def test_npz_is_not_compressed(tmp_path: Path) -> None:
    path = written(tmp_path / "a.npz")
    with np.load(path) as found:
        assert all(same(found[name], i) for i, name in enumerate(NAMES))
        assert found["t_s"].dtype == np.dtype("<f8")
    with zipfile.ZipFile(path) as archive:
        assert {each.compress_type for each in archive.infolist()} == {zipfile.ZIP_STORED}
    assert not (tmp_path / "a.npz.columns").exists()


def test_mat_has_a_variable_a_column_with_a_name_that_matlab_takes(tmp_path: Path) -> None:
    from scipy.io import loadmat, whosmat

    path = written(tmp_path / "a.mat")
    found = loadmat(str(path))
    names = [name[:63] for name in NAMES]
    assert all(same(found[name], i) for i, name in enumerate(names))
    assert whosmat(str(path)) == [(name, (4, 1), "double") for name in names]
    assert found["__version__"] == "1.0"
    assert path.read_bytes()[:39] == b"MATLAB 5.0 MAT-file, calibrated samples"
    assert not (tmp_path / "a.mat.columns").exists()


def test_a_mat_file_of_more_than_2_gb_is_refused_before_it_is_begun(tmp_path: Path) -> None:
    most = (2**31 - 1) // 8
    MatSamples(tmp_path / "a.mat", SampleColumns(("t_s",), most, "housing", is_si=True)).abandon()
    with refused(DataRefused, None, "2.1 GB", ".mat"):
        MatSamples(tmp_path / "b.mat", SampleColumns(("t_s",), most + 1, "housing", is_si=True))
    assert list(tmp_path.iterdir()) == []


def test_mcap_has_a_message_a_row_at_its_time(tmp_path: Path) -> None:
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    with written(tmp_path / "a.mcap").open("rb") as stream:
        found = [*make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages()]
    assert [each.log_time for _, _, each, _ in found] == [0, 20_000_000, 12_345_678_901, 13_000_000_000]
    assert [each.publish_time for _, _, each, _ in found] == [each.log_time for _, _, each, _ in found]
    assert [each.sequence for _, _, each, _ in found] == [0, 1, 2, 3]
    assert {channel.topic for _, channel, _, _ in found} == {"/imu/calibrated"}
    for i, name in enumerate(NAMES):
        name = "temperature_c" if name == "temp_c" else name
        assert same([getattr(message, name) for *_, message in found], i), name


def test_a_ros_bag_has_forces_rates_and_temperatures_as_rep_145_asks(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from rosbags.highlevel import AnyReader

    with AnyReader([written(tmp_path / "a.ros2")]) as reader:
        assert {each.topic: each.msgtype for each in reader.connections} == {
            "/imu/data": "sensor_msgs/msg/Imu", "/imu/temperature": "sensor_msgs/msg/Temperature",
        }  # fmt: skip
        found: dict[str, list[Any]] = {"/imu/data": [], "/imu/temperature": []}
        for channel, at, data in reader.messages():
            message: Any = reader.deserialize(data, channel.msgtype)
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == at
            assert message.header.frame_id == "housing"
            found[channel.topic].append((at, message))
    imu = found["/imu/data"]
    assert [at for at, _ in imu] == [0, 20_000_000, 12_345_678_901, 13_000_000_000]
    for i, name in enumerate(("linear_acceleration", "angular_velocity")):
        for axis in range(3):
            assert same([getattr(getattr(each, name), "xyz"[axis]) for _, each in imu], 1 + 3 * i + axis)
    assert [each.orientation_covariance[0] for _, each in imu] == [-1.0] * 4
    assert [each.linear_acceleration_covariance[0] for _, each in imu] == [0.0, 0.0, 0.0, -1.0]
    assert [each.angular_velocity_covariance[0] for _, each in imu] == [0.0, 0.0, -1.0, 0.0]
    assert not any(each.orientation_covariance[1:].any() for _, each in imu)
    turned = imu[0][1].orientation
    assert (turned.x, turned.y, turned.z, turned.w) == (0.0, 0.0, 0.0, 1.0)
    warm = [(at, each.temperature, each.variance) for at, each in found["/imu/temperature"]]
    assert warm == [(0, 21.5, 0.0), (12_345_678_901, 22.0, 0.0), (13_000_000_000, 22.5, 0.0)]


def test_no_rows_are_a_file_without_any(tmp_path: Path) -> None:
    for suffix in WRITERS:
        if suffix == ".ros2":
            pytest.importorskip("rosbags")
        path = tmp_path / f"a{suffix}"
        writer = writer_for(path)(path, SampleColumns(NAMES[:7], 0, "housing", is_si=True))
        writer.write([np.zeros(0)] * 7)
        writer.finish()
        assert path.exists()
    assert (tmp_path / "a.csv").read_text() == ",".join(NAMES[:7]) + "\n"


def test_a_suffix_that_nothing_writes_is_refused(tmp_path: Path) -> None:
    for name in ("a.txt", "a"):
        with refused(DataRefused):
            writer_for(tmp_path / name)
    assert writer_for(tmp_path / "A.CSV") is WRITERS[".csv"]
