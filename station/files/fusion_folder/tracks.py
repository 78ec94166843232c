"""``[tracks]`` of a fusion folder: rows ``t_s,feature,u_px,v_px``, written and read."""

from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.vision.feature_tracker import LensModel
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.fusion_folder.fusion_columns import TRACKS_COLUMNS, read_table, stacked
from station.files.fusion_folder.fusion_schema import LensTable

LARGEST = 2.0**53  # of a feature's number


def camera_of(table: LensTable) -> PinholeCamera:
    """Return the camera that a table describes."""
    T = np.array(table.imu_from_camera)
    place, row = (T[:3, :3], T[:3, 3]), table.row_time_s
    return PinholeCamera(table.fx_px, table.fy_px, table.cx_px, table.cy_px, table.std_px, *place, row)


def lens_of(table: LensTable) -> LensModel:
    """Return the lens that a table describes."""
    return LensModel(table.fx_px, table.fy_px, table.cx_px, table.cy_px, np.array(table.distortion))


def read_tracks(folder: Path, name: str, line: int) -> FeatureTracks:
    """Read the tracks file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first cell that is no number, time that runs back, or feature that is none or twice in a frame.
    """
    read = read_table(folder, name, line, TRACKS_COLUMNS, repeats=True)
    t, feature = read.columns["t_s"], read.columns["feature"]
    _refuse_features(t, feature, read.first_line, read.file)
    return FeatureTracks(t, feature.astype(np.int64), stacked(read, ("u_px", "v_px")))


def _refuse_features(t: FloatArray, feature: FloatArray, line: int, file: str) -> None:
    wrong = np.flatnonzero((feature != np.floor(feature)) | (feature < 0) | (feature >= LARGEST))
    if len(wrong):
        raise DataRefused(file, line + int(wrong[0]), f"feature {feature[wrong[0]]:g}", "a whole number from 0 on")
    order = np.lexsort((feature, t))
    twice = np.flatnonzero((np.diff(t[order]) == 0) & (np.diff(feature[order]) == 0))
    if len(twice):
        row = int(order[twice + 1].min())
        raise DataRefused(
            file, line + row, f"feature {feature[row]:.0f} again at t_s {t[row]:.6f}", "each feature once a frame"
        )


def write_tracks(path: Path, tracks: FeatureTracks) -> None:
    """Write tracks, there whole or what stood there before; raise `CannotWrite` if it cannot be."""
    rows = zip(tracks.t.tolist(), tracks.feature.tolist(), tracks.uv.tolist(), strict=True)
    text = "".join(f"{t:.6f},{feature},{u:.3f},{v:.3f}\n" for t, feature, (u, v) in rows)
    replace_file(path, ("t_s,feature,u_px,v_px\n" + text).encode())
