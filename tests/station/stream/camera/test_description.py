"""A camera's file is read, or refused with its line."""

from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.camera_truth import CameraTruth, camera_toml
from station.errors import DataRefused
from station.files.fusion_folder.tracks import camera_of, lens_of
from station.stream.camera.description import read_description

URL = "camera:http://127.0.0.1:8080/stream"


def written(folder: Path, text: str) -> Path:
    path = folder / "eye.toml"
    path.write_text(text)
    return path


def test_what_the_simulated_camera_is_described_as_is_read(tmp_path: Path) -> None:
    truth = CameraTruth()
    found = read_description(written(tmp_path, camera_toml(truth, URL) + "time_offset_s = -0.03\n"))
    assert found.address.scheme == "camera"
    assert found.table.time_offset_s == -0.03
    camera = camera_of(found.table)
    assert np.allclose(camera.C_bc, truth.C_bc)
    assert np.allclose(camera.t_bc, truth.t_bc)
    assert np.allclose(lens_of(found.table).K, truth.K)
    assert found.content == (tmp_path / "eye.toml").read_bytes()


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        (URL, "tcp://127.0.0.1:8080", 2, "camera:http://HOST:PORT/PATH"),
        (URL, "camera:nothing", 2, "camera:"),
        ("fx_px = 230.0", "fx_px = -1.0", 4, "fx_px"),
        ("fx_px = 230.0\n", "", 1, "fx_px"),
        ("std_px", "std_pixel", 3, "std_pixel"),
        ('"camera/1"', '"camera/2"', 1, "camera/1"),
    ],
)
def test_what_is_wrong_is_refused_with_its_line(tmp_path: Path, old: str, new: str, line: int, said: str) -> None:
    path = written(tmp_path, camera_toml(CameraTruth(), URL).replace(old, new))
    with pytest.raises(DataRefused) as refused:
        read_description(path)
    assert refused.value.line == line
    assert said in str(refused.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataRefused, match="no readable file"):
        read_description(tmp_path / "none.toml")
