"""Fusion folders (`fusion/1`, docs/how-to/locate.md): IMU, GNSS and odometry of a drive or flight.

`fusion_schema` declares the keys of ``fusion.toml``; `fusion_reading` reads a folder by `fusion_tables` (CSV
files, tracks, wheel, TUM trajectories) and checks plausibility; `fusion_writing` writes one.
"""

from station.files.fusion_folder.fusion_reading import FusionLog, read_fusion
from station.files.fusion_folder.fusion_tables import read_tum, write_tum

__all__ = ["FusionLog", "read_fusion", "read_tum", "write_tum"]
