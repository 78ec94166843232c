"""Fusion folders (`fusion/1`, docs/how-to/locate.md): IMU, GNSS and odometry of a drive or flight."""

from station.files.fusion_folder.fusion_reading import FusionLog, read_fusion
from station.files.fusion_folder.tum import read_tum, write_tum

__all__ = ["FusionLog", "read_fusion", "read_tum", "write_tum"]
