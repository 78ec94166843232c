"""Print what followed features are worth on a rendered drive: `python -m tests.benchmarks.tracks_on_a_drive`.

Points 12 to 24 images old against true projections of where each feature was first seen, on two stretches; how
many are followed; processor time an image; and the live window's heading by these features (``--seeds`` of IMU and
receiver) from 9 s after setting off.
"""

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.camera_images import CameraImages
from drivers.simulated.camera_truth import CameraTruth
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray, IntArray
from procedures.fusion.vision.feature_tracker import FeatureTracker, LensModel
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera
from tests.drivers.simulated.drives import bends
from tests.station.monitor import driving, sighted

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
TRACK = bends(60.0, still=16.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
CAMERA = CameraTruth()
IMAGES = 660
STRETCHES = ((17.5, 30.0), (30.0, 44.0))
FROM, UNTIL = 25.0, 40.0


@dataclass(frozen=True)
class Followed:
    """Features of each image, and processor time an image [ms]."""

    tracks: FeatureTracks
    took_ms: float


def followed(images: CameraImages) -> Followed:
    """Return what the drive's images leave."""
    follower, took = FeatureTracker(LensModel(CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy, np.zeros(4))), 0.0
    times, features, points = list[FloatArray](), list[IntArray](), list[FloatArray]()
    for k in range(IMAGES):
        image = images.image(k / CAMERA.rate_hz)
        began = time.process_time()
        feature, uv = follower.follow(image)
        took += time.process_time() - began
        times.append(np.full(len(feature), k / CAMERA.rate_hz))
        features.append(feature)
        points.append(uv)
    tracks = FeatureTracks(np.concatenate(times), np.concatenate(features), np.concatenate(points))
    return Followed(tracks, 1e3 * took / IMAGES)


def offsets(images: CameraImages, tracks: FeatureTracks) -> FloatArray:
    """Return rows (n, 4): time [s], age [images], and how far a point is off [px]."""
    first, rows = dict[int, tuple[int, FloatArray]](), list[tuple[float, ...]]()
    times, begin = tracks.frames()
    for k, t in enumerate(times.tolist()):
        which = slice(int(begin[k]), int(begin[k + 1]))
        C, p = images.pose(t)
        ends = images.room.ends(CAMERA, C, p, tracks.uv[which])
        for number, uv, end in zip(tracks.feature[which].tolist(), tracks.uv[which], ends, strict=True):
            since, place = first.setdefault(number, (k, end))
            y = CAMERA.K @ C.T @ (place - p)
            rows.append((t, k - since, *(uv - y[:2] / y[2])))
    return np.array(rows)


def say(rows: FloatArray) -> None:
    """Print a line for each stretch."""
    for low, high in STRETCHES:
        part = rows[(rows[:, 0] >= low) & (rows[:, 0] < high)]
        _, count = np.unique(part[part[:, 1] >= 3, 0], return_counts=True)
        off = part[(part[:, 1] >= 12) & (part[:, 1] < 24), 2:]
        half, most = np.quantile(np.linalg.norm(off, axis=1), [0.5, 0.9])
        mean = off.mean(axis=0)
        print(
            f"{low:.0f} to {high:.0f} s: median {half:.2f} px, 90 % within {most:.2f} px, mean {mean[0]:.3f} "
            f"{mean[1]:.3f} px; followed for three images or more: mean {count.mean():.0f}, fewest {count.min()}"
        )


def headings(tracks: FeatureTracks, std: float, seeds: int) -> None:
    """Print how far the live heading is off for each seed."""
    sighted.simulate_tracks = lambda *_: tracks  # type: ignore[attr-defined]
    eye = PinholeCamera(CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy, std, CAMERA.C_bc, CAMERA.t_bc)
    driving.CAMERA = eye  # type: ignore[attr-defined]
    for seed in range(1, seeds + 1):
        rig = driving.DriveRig(TRUTH, TRACK, AUTOPILOT, sees=(0.04, (0.0, 0.0)), told=-0.04, seed=seed)
        rig.run(UNTIL)
        found = [view.location for view in rig.lines if view.location and view.location.t > FROM]
        v = [TRACK.velocity(each.t) for each in found]
        true = np.degrees(np.arctan2([each[0] for each in v], [each[1] for each in v]))
        off = (np.array([each.heading for each in found], float) - true + 180) % 360 - 180
        ratio = np.abs(off / np.array([each.heading_std for each in found], float)).max()
        print(
            f"std_px {std}, seed {seed}: heading off by {np.abs(off).max():.2f} deg at most, "
            f"rms {np.sqrt(np.mean(off**2)):.2f}, at most {ratio:.1f} sigma",
            flush=True,
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--std", type=float, nargs="+", default=[1.0, 0.5])
    given = parser.parse_args()
    drive = CameraImages(TRUTH, CAMERA, (), TRACK, 1)
    seen = followed(drive)
    print(f"processor time {seen.took_ms:.1f} ms an image")
    say(offsets(drive, seen.tracks))
    for std_px in given.std:
        headings(seen.tracks, std_px, given.seeds)
