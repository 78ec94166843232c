"""Fusion folders (`fusion/1`, docs/locate.md): IMU, GNSS and odometry of a drive or a flight, to be located."""

from station.files.fusion_folder.fusion_reading import FusionLog, read_fusion
from station.files.fusion_folder.tum import read_tum, write_tum

__all__ = ["FusionLog", "read_fusion", "read_tum", "write_tum"]
