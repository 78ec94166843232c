"""Counters of frames received, and of the faults that they had. Faults are made by `drivers.simulated.faults`."""

from dataclasses import dataclass


@dataclass(slots=True)
class FrameCounters:
    """What a decoder met since it was made.

    ``frames`` IMU frames accepted, ``identities`` frames of identity alone, ``skipped_bytes`` in no accepted
    frame, ``bad_crc`` frames whose check failed, ``bad_length`` known kinds with another length or number of
    fields than their own, ``counter_jumps`` breaks of the sample sequence (see `drivers.counter_and_time_wrap`),
    ``bad_status`` accepted frames that the format reads as unhealthy or that step by more than it can. Where a
    sample takes several frames, ``frames`` are samples, ``incomplete`` those given up, ``late`` frames repeated or
    come after their sample, ``contradicted`` those that say something else than its own, ``foreign`` those of
    somebody else, ``bus_errors`` what the bus reported of itself.
    """

    frames: int = 0
    identities: int = 0
    skipped_bytes: int = 0
    bad_crc: int = 0
    bad_length: int = 0
    counter_jumps: int = 0
    bad_status: int = 0
    incomplete: int = 0
    late: int = 0
    contradicted: int = 0
    foreign: int = 0
    bus_errors: int = 0
