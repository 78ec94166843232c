"""A rest during which attitude filters run: the calibration can be compared with the unit's later use.

It is judged like a soak. The axes are those that lie north, east and down in its position, so that roll and pitch
are zero for a correctly placed cube. The calibration is that of the steps accepted so far, solved in another
thread; samples recorded before it is ready are processed afterwards.
"""

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from procedures.attitude.attitude_log import ENU_NED, AttitudeLog, inclination
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.campaign.plan_steps import Monitor
from procedures.errors import ProcedureError
from procedures.positions import nominal_C_lb
from station.attitude.error_at_rest import ErrorAtRest
from station.attitude.live_filters import LiveFilters, joint_filter_reading
from station.attitude.live_kalman_filter import AttitudeEstimator
from station.attitude.live_readings import FilterReading, difference
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.filter_settings import filter_settings
from station.calibrated.rates_and_forces import Sensors
from station.errors import StationError
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.stages.dwell_stage import DwellStage
from station.guide.stages.stage import NextStage, Stage
from station.guide.stages.stage_context import StageContext
from station.guide.view import FilterView, MonitoredView
from station.stream.live.stillness import Block
from station.stream.recorder.sample_buffer import SampleRun

TICK_S = 0.1
SETTLED_SHARE = 0.5  # of the step, whose mean is its result
WAIT_S = 0.2  # for a calibration that is being solved, at each second of a step that is recorded


class FiltersAtRest:
    """Runs attitude filters on the blocks of a rest; ``why`` is the reason if it does not."""

    def __init__(self, context: StageContext, step: Monitor) -> None:
        self._context, self._step = context, step
        assert context.feed.unit is not None, "the guide starts when the unit is identified"
        aside = ThreadPoolExecutor(1, "calibration so far")
        self._asked: Future[AppliedCalibration] = aside.submit(
            context.recorder.interim_calibration, context.feed.unit, context.feed.wire
        )
        aside.shutdown(wait=False)
        self._waiting: list[Block] = []  # not read yet
        self._taken = 0  # samples up to here were taken
        self._end: int | None = None  # of those that were read
        self._discarded_s = 0.0
        self._sensors: Sensors | None = None
        self._filters: LiveFilters | None = None
        self._rest = ErrorAtRest(context.recorder.gravity, context.bench.latitude, 0.0)
        self._read: list[tuple[int, tuple[FilterReading, ...]]] = []  # each with its tick's first sample
        self.calibration, self.why = "", ""

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        return self._waiting[0].first if self._waiting else None

    def take(self, accepted: Sequence[Block]) -> None:
        """Take the seconds accepted so far; those that were not taken before are read."""
        self._waiting += [block for block in accepted if block.first >= self._taken]
        self._taken = max((block.last for block in accepted), default=self._taken)
        if self._asked.done():
            self._go_on()

    def is_read(self) -> bool:
        """Say whether all is read, or that it cannot be; wait for a calibration a moment."""
        try:
            self._asked.result(WAIT_S)
        except TimeoutError:
            return False
        except (StationError, ProcedureError):
            pass  # reported by `_begun`
        self._go_on()
        return True

    def result(self, runs: Sequence[SampleRun]) -> dict[str, object]:
        """Return the values for the step's table in ``campaign.toml``, from ``runs``, the accepted samples."""
        accepted = [filters for at, filters in self._read if any(first <= at < last for first, last in runs)]
        settled = accepted[round(len(accepted) * SETTLED_SHARE) :]
        if not settled:
            return {"calibration": f"none: {self.why or 'the rest is too short'}"}
        angles = np.array([[[reading.roll, reading.pitch] for reading in filters] for filters in settled])
        downs = np.array([[reading.down for reading in filters] for filters in settled])
        mean, middle = angles.mean(axis=0), downs.mean(axis=0)
        scatter = np.degrees(np.sqrt(np.mean(inclination(downs, middle[None]) ** 2, axis=0)))
        values: dict[str, object] = {
            "calibration": self.calibration, "roll_deg": mean[:, 0].tolist(), "pitch_deg": mean[:, 1].tolist(),
            "scatter_deg": scatter.tolist(),
        }  # fmt: skip
        if len(middle) > 1:
            values["difference_deg"] = float(np.degrees(inclination(middle[0], middle[1])))
        if (errors := self._rest.comparison) is not None:
            at_rest = errors.calibrated
            at = {"level_deg": at_rest.level, "drift_deg_h": at_rest.drift, "g_error_mg": at_rest.g}
            values |= {name: value for name, value in at.items() if np.isfinite(value)}
        return values

    def view(self) -> MonitoredView:
        """Return what is shown."""
        filters = self._read[-1][1] if self._read else ()
        apart = difference(filters)
        waits = "" if self._asked.done() else "solving the accepted steps"
        return MonitoredView(
            filters=tuple(FilterView(name=one.name, roll_deg=one.roll, pitch_deg=one.pitch) for one in filters),
            difference_deg=None if apart is None else apart.angle,
            text=self.why or waits or ("" if filters else "measuring the noise"),
        )  # fmt: skip

    def _go_on(self) -> None:
        if self._filters is None and not self._begun():
            self._waiting.clear()
            return
        assert self._sensors is not None
        assert self._filters is not None
        period, size = self._context.feed.period, max(1, round(TICK_S / self._context.feed.period))
        for block in self._waiting:
            if block.is_broken:
                self._filters.reset()
            elif self._end is not None:  # the attitude is unchanged: for a filter discarded seconds do not exist
                self._discarded_s += (block.first - self._end) * period
            self._end = block.last
            for at in range(block.first, block.last, size):
                tick = self._sensors.take(self._context.feed.buffer.block(at, min(at + size, block.last)))
                found = self._filters.take(tick.t - self._discarded_s, tick.calibrated)
                if found is not None:
                    reading, filters = found
                    self._rest.take(tick, len(tick.t) * period, rests=reading.mode == "at rest")
                    self._read.append((at, filters or (joint_filter_reading(reading, "none"),)))
        self._waiting.clear()

    def _begun(self) -> bool:
        """Make the filters with the calibration that was found; keep the reason if there is none."""
        try:
            applied = self._asked.result()
        except (StationError, ProcedureError) as error:
            self.why = str(error)
            return False
        context, feed = self._context, self._context.feed
        C = ENU_NED @ nominal_C_lb(self._step.position) @ context.C_sb.T
        counts = feed.wire.output == "increments"
        self._sensors = Sensors(applied.document, applied.nominal, C, feed.period, counts=counts)
        gravity, latitude = context.recorder.gravity, context.bench.latitude
        self._rest = ErrorAtRest(gravity, latitude, 0.0, self._sensors.quantum(TICK_S))
        quantum = self._sensors.quantum(feed.period)

        def settings(log: AttitudeLog, knows_heading: bool) -> KalmanSettings:
            return filter_settings(applied.document, "none", log, gravity, latitude, knows_heading, quantum)

        joint = AttitudeEstimator("none", settings, 0.0)
        self._filters = LiveFilters(self._step.filters, "none", joint, applied.document, gravity)
        self.calibration = applied.in_use.text
        return True


class MonitorStage(DwellStage):
    """One attempt at a monitor step on its face."""

    def __init__(self, context: StageContext, step: Monitor, again: NextStage) -> None:
        super().__init__(context, step.face, [step], again)
        self._filters = FiltersAtRest(context, step)

    @property
    def oldest(self) -> int | None:
        needed = [each for each in (self._filters.oldest, super().oldest) if each is not None]
        return min(needed, default=None)

    def _restarted(self, block: Block, look: BlockLook) -> Stage | None:
        restarted = super()._restarted(block, look)
        self._filters.take(self._dwelling.kept)  # without the discarded seconds: a filter bridges them
        return restarted

    def shown(self) -> dict[str, Any]:
        return super().shown() | {"monitored": self._filters.view()}

    def _completed(self) -> Stage:
        return super()._completed() if self._filters.is_read() else self

    def _result(self) -> dict[str, object]:
        return self._filters.result(self._dwelling.runs())
