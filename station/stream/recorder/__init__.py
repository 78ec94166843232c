"""From bytes to accepted steps on the disk: decoding with gaps seen, cutting, writing, hashing."""

from station.stream.recorder.accepted_step_writer import CampaignRecorder, open_campaign
from station.stream.recorder.connected_unit import Unit, UnitChanged, UnitUnknown
from station.stream.recorder.raw_check import check_raw_bytes
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_stream import DecodedChunk, SampleStream

__all__ = [
    "CampaignRecorder",
    "DecodedChunk",
    "SampleBuffer",
    "SampleStream",
    "Unit",
    "UnitChanged",
    "UnitUnknown",
    "check_raw_bytes",
    "open_campaign",
]
