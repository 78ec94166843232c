"""From bytes to accepted steps on the disk: decoding with gaps seen, cutting, writing, hashing."""

from station.recorder.campaign import CampaignRecorder, open_campaign
from station.recorder.raw_check import check_raw_bytes
from station.recorder.stream import Piece, SampleStream
from station.recorder.tape import Tape
from station.recorder.unit import Unit, UnitChanged, UnitUnknown

__all__ = [
    "CampaignRecorder",
    "Piece",
    "SampleStream",
    "Tape",
    "Unit",
    "UnitChanged",
    "UnitUnknown",
    "check_raw_bytes",
    "open_campaign",
]
