"""Writes the accepted steps of a guided campaign and its notes into the folder, and solves them in between.

A sample is written twice: its bytes into the session's recording, and bytes and counts into its step's file. The
bytes per sample are the worst of all formats with 16 random bits in every channel and a sample per read, rounded
up; `tests/station/guide/test_disk_space.py` measures them again.
"""

import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from drivers.wire import WireFormat
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell, Step
from procedures.errors import ProcedureError
from procedures.frames import TRIADS
from procedures.geodesy import normal_gravity
from procedures.units import STANDARD_GRAVITY
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration, find_calibration
from station.errors import DataRefused, DiskFull
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.files.campaign_folder.plan_file import (
    UnitRecord,
    keep_left_out,
    keep_no_move,
    keep_plan,
    read_note,
    write_note,
    write_tables,
)
from station.guide.campaign.checklist import step_duration
from station.stream.connected_unit import Unit
from station.stream.recorder.accepted_step_writer import CampaignRecorder, MovedFrom
from station.stream.recorder.sample_buffer import SampleBuffer, SampleRun


class FolderRecorder:
    """When `accept` returns, the step is on the disk and in the database."""

    def __init__(self, recorder: CampaignRecorder) -> None:
        self._recorder = recorder

    def accept(
        self,
        step: Step,
        buffer: SampleBuffer,
        runs: Sequence[SampleRun],
        *,
        kept_seat: Sequence[float] | None,
        turn_on: int,
        read: Mapping[str, object] = MappingProxyType({}),
        moved: MovedFrom | None = None,
        seats: Mapping[Dwell, FloatArray | None] = MappingProxyType({}),
    ) -> str:
        """Record ``step`` as the samples of ``runs``, the unit switched on for the ``turn_on``-th time, from 1.

        ``kept_seat`` (2,) [rad]: kept though it sits so far off. ``read`` is what a monitor read, by key;
        ``moved`` how the cube came there. ``seats`` says how far off (2,) [rad] the cube sat in dwells before,
        None: well; that is written with it. Returns the name of its file.
        """
        spans = discarded_spans(runs, buffer)
        values: dict[str, object] = dict(read) if kept_seat is None else {"kept_seat_rad": list(kept_seat)}
        values |= {"turn_on": turn_on} if turn_on > 1 else {}
        off = {each.name: None if seat is None else seat.tolist() for each, seat in seats.items()}
        path = self._recorder.accept(step, buffer, runs, values, moved, off)
        if spans:
            period = self._recorder.tables.imu.sample_period_s
            keep_left_out(self._recorder.folder, path.name, [span * period for span in spans])
        return path.name

    @property
    def gravity(self) -> float:
        """The site's gravity [m/s2], normal where none is stated."""
        site = self._recorder.tables.site
        if site is None:
            return STANDARD_GRAVITY
        return site.gravity_m_s2 or normal_gravity(float(np.radians(site.latitude_deg)), site.height_m)

    def interim_calibration(self, unit: Unit, wire: WireFormat) -> AppliedCalibration:
        """Return the campaign's own calibration, without effects; else the unit's stored one, or its maker's.

        Raises
        ------
        DataRefused
            If there is none of them.
        """
        try:
            loaded = read_for_solve([self._recorder.folder])
            from procedures.calibration.joint_calibration import solve  # scipy, kernels: only where it is solved
            from station.results.result_formats import document_of
            from station.results.solution_json import solution_document

            document = document_of(solution_document(solve([one.campaign for one in loaded]), loaded))
            if all(name in document for name in TRIADS):
                return AppliedCalibration({**document, "effects": []}, None, InUse("this campaign"))
        except (DataRefused, ProcedureError):
            pass  # nothing recorded yet, or too little
        return find_calibration(None, self._recorder.database_url, unit, wire)

    def keep_steps(self, steps: Sequence[Step]) -> None:
        """Keep what the campaign is to have."""
        keep_plan(self._recorder.folder, tuple(steps))

    def keep_no_move(self, step: Step, why: str) -> None:
        """Keep why no use is made of the move to a step, empty if one is."""
        keep_no_move(self._recorder.folder, step.name, why)

    def keep_first_rest(self, rate: FloatArray, noise: FloatArray) -> None:
        """Keep how the unit looks at rest, rate (6,) [count/s] and noise (6,), to recognise it later."""
        known = read_note(self._recorder.folder, UnitRecord)
        if known is not None and known.rate is None:
            seen = {"rate": tuple(rate.tolist()), "noise": tuple(noise.tolist())}
            write_note(self._recorder.folder, known.model_copy(update=seen))

    def widen_closure(self, before_deg: float, now_deg: float) -> None:
        """Say in ``campaign.toml`` that the operator states a wider closure [deg], and what stood first."""
        procedure = self._recorder.tables.procedure
        first = procedure.closure_widened_from_deg or before_deg
        self._set_procedure({"closure_std_deg": now_deg, "closure_widened_from_deg": first})

    def set_unsettled(self, gyro_deg_h: float, accelerometer_g: float) -> None:
        """Say in ``campaign.toml`` that the unit was not settled: 1 sigma of its bias from dwell to dwell."""
        values = {"unsettled_gyro_deg_h": gyro_deg_h, "unsettled_accelerometer_g": accelerometer_g}
        self._set_procedure({name: value for name, value in values.items() if value > 0})

    def _set_procedure(self, values: Mapping[str, float]) -> None:
        recorder = self._recorder
        procedure = recorder.tables.procedure.model_copy(update=values)
        recorder.tables = recorder.tables.model_copy(update={"procedure": procedure})
        write_tables(recorder.folder, recorder.tables)


def discarded_spans(runs: Sequence[SampleRun], buffer: SampleBuffer) -> list[int]:
    """Return how many samples each step from run to run is, where nothing is missing in between."""
    between = [(before[1], after[0]) for before, after in pairwise(runs)]
    return [first - last + 1 for last, first in between if buffer.last_break(last - 1, first + 1) is None]


RAW_BYTES = 75  # of a sample
STEP_BYTES = 135  # of a sample
WARM_UP_S = 1800.0
REPEATS_FACTOR = 1.5  # steps are done again, and people take breaks
RESULTS_BYTES = 20_000_000  # report, diagnosis, database


class DiskSpace(NamedTuple):
    """Bytes that a campaign needs, and that are free in its folder; None where that is not known."""

    needed: int
    free: int | None


def disk_needed(steps: Sequence[Step], rate_hz: float, warm_up_s: float = WARM_UP_S) -> int:
    """Return the bytes that ``steps`` will take at ``rate_hz`` samples a second, repeats and breaks included."""
    recorded_s = sum(step_duration(step) for step in steps)  # the moves between them too
    written = recorded_s * STEP_BYTES + (warm_up_s + recorded_s) * RAW_BYTES
    return round(REPEATS_FACTOR * written * rate_hz) + RESULTS_BYTES


def disk_free(folder: Path) -> int | None:
    """Return the bytes that this user may still write where ``folder`` is or will be; None if not known."""
    there = folder.absolute()
    while not there.exists() and there != there.parent:
        there = there.parent
    try:
        found = os.statvfs(there)
    except OSError:
        return None
    return found.f_bavail * found.f_frsize


def disk_for(folder: Path, steps: Sequence[Step], rate_hz: float, warm_up_s: float = WARM_UP_S) -> DiskSpace:
    """Return what a campaign of ``steps`` in ``folder`` needs and has."""
    return DiskSpace(disk_needed(steps, rate_hz, warm_up_s), disk_free(folder))


def refuse_full(folder: Path, steps: Sequence[Step], rate_hz: float, warm_up_s: float = WARM_UP_S) -> None:
    """Raise `DiskFull` where a campaign of ``steps`` has not enough room in ``folder``."""
    needed, free = disk_for(folder, steps, rate_hz, warm_up_s)
    if free is not None and free < needed:
        raise DiskFull(folder, needed, free)
