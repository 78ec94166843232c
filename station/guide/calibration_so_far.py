"""What a unit is read by in the middle of its campaign: the steps accepted so far, where they determine it."""

from pathlib import Path

from drivers.wire import WireFormat
from procedures.errors import ProcedureError
from procedures.frames import TRIADS
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration, find_calibration
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.stream.connected_unit import Unit

THIS_CAMPAIGN = "this campaign"


def calibration_so_far(folder: Path, database: str, unit: Unit, wire: WireFormat) -> AppliedCalibration:
    """Return the campaign's own calibration, without effects; else the unit's stored one, or its maker's scale.

    Raises
    ------
    DataRefused
        If there is none of them.
    """
    try:
        loaded = read_for_solve([folder])
        from procedures.calibration.joint_calibration import solve  # scipy and kernels: only where it is solved
        from station.results.solution_json import solution_document

        document = solution_document(solve([one.campaign for one in loaded]), loaded)
        if all(name in document for name in TRIADS):
            return AppliedCalibration({**document, "effects": []}, None, InUse(THIS_CAMPAIGN))
    except (DataRefused, ProcedureError):
        pass  # nothing recorded yet, or too little
    return find_calibration(None, database, unit, wire)
