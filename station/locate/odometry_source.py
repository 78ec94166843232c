"""Locate by somebody else's odometry."""

from procedures.fusion.odometry import RecordedOdometry, without_restarts
from station.errors import DataRefused
from station.files.fusion_folder import FusionLog
from station.locate.outer_layer import through_graph
from station.locate.result import Located


def by_odometry(log: FusionLog, _layers: int = 2) -> Located:
    """Locate by a recorded odometry."""
    if log.odometry is None or log.table.odometry is None:
        raise DataRefused(log.folder / "fusion.toml", None, "no [odometry]", "one, for this source", "add it")
    kept, dropped = without_restarts(log.odometry)
    if len(kept) < 2:
        file = log.folder / log.table.odometry.file
        raise DataRefused(file, None, "a restart at the end", "odometry data after it")
    said = f"{log.table.odometry.file}: {dropped} poses before an impossible step were discarded"
    return through_graph(log, RecordedOdometry(kept), (said,) if dropped else ())
