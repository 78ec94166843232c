"""`station devices` on cameras."""

import json

import pytest

from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.companions.truths import CameraTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from station import cli
from tests.patience import longer, paced

pytest.importorskip("cv2", reason="opencv is not installed")
SMALL = CameraTruth(width=160, height=120, fx=100.0, fy=100.0, cx=79.5, cy=59.5)


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = cli.run(["devices", *words])
    reported = capsys.readouterr()
    return code, reported.out, reported.err


def test_a_camera_says_images_size_bytes_and_rate(capsys: pytest.CaptureFixture[str]) -> None:
    seconds = f"{longer(0.6):g}"
    with SimulatedCamera(Truth(), SMALL, speed=paced(4)) as camera:
        code, out, _ = run(capsys, "--url", camera.url, "--seconds", seconds)
        several, more, _ = run(capsys, "--url", camera.url, "--json", "--seconds", seconds)
    assert (code, several) == (0, 0)
    lines = dict(line.split(None, 1) for line in out.splitlines())
    assert lines["format"] == "MJPEG"
    assert lines["size"] == "160 x 120 px"
    assert float(lines["received"].split()[0]) > 0  # by the clock: what this machine gives the camera
    assert lines["rate"] == "14.9997 Hz by its own time"
    assert lines["errors"].startswith("0 ")
    [found] = json.loads(more)["devices"]
    assert (found["looks_like"], found["about"], found["trouble"]) == ("MJPEG", "160 x 120 px", "")
    assert found["frames_s"] > 0


def test_a_camera_of_which_no_image_comes_is_exit_4(capsys: pytest.CaptureFixture[str]) -> None:
    faults = [TimedFault("cut", at_s=0.0, seconds=1000.0)]
    with SimulatedCamera(Truth(), SMALL, faults) as camera:
        code, _, err = run(capsys, "--url", camera.url, "--seconds", f"{longer(0.5):g}")
    assert (code, err.count("\n")) == (4, 1)


def test_silence_and_a_wrong_path_are_exit_4(capsys: pytest.CaptureFixture[str]) -> None:
    faults = [TimedFault("stall", at_s=0.0, seconds=1000.0)]
    with SimulatedCamera(Truth(), SMALL, faults) as camera:
        code, _, err = run(capsys, "--url", camera.url, "--seconds", "0.2")
        wrong, out, _ = run(capsys, "--url", camera.url, "--url", camera.url[:-1], "--seconds", "0.2")
    assert (code, wrong) == (4, 4)
    assert "404" in out
    assert "0.2 s" in err
