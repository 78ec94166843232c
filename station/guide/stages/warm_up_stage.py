"""Wait until the unit has settled; the cube rests wherever it stands."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.dwell_length import dwell_seconds
from procedures.bench.warm_up import IntervalMeans, WarmUpState, unsettled_bias, warm_up
from procedures.campaign.plan_steps import Dwell
from procedures.geodesy import EARTH_RATE
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G
from station.guide.campaign.accepted_steps import triad_estimates
from station.guide.campaign.checklist import MOVE_S
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.stages.stage import Stage
from station.guide.stages.stage_context import StageContext
from station.guide.view import WarmUpView
from station.guide.wording import rounded
from station.stream.live.stillness import MIN_VARIANCE, TICKS_PER_BLOCK, Block, runs_of_blocks, series_of_runs

MEAN_BLOCKS = 10
NOISE_ROWS = 6
MIN_SHOWN_LEFT_S = 1.0


class WarmUpStage(Stage):
    """Collects means of ten seconds at rest until limits learnt from them are met."""

    def __init__(self, context: StageContext, then: Callable[[StageContext], Stage]) -> None:
        super().__init__(context)
        self._then = then
        self._blocks: list[Block] = []
        self._rows: list[list[Block]] = []
        self._marks: list[float] = []
        self._state: WarmUpState | None = None
        self._began: float | None = None
        self._now, self._hint, self._stated = 0.0, "", 0.0

    def take(self, block: Block, look: BlockLook) -> Stage:
        self._began = block.begins if self._began is None else self._began
        self._now, self._hint = block.ends, look.hindrance
        if look.hindrance:
            self._blocks = []
            self._marks.append(block.ends)
            return self
        self._blocks.append(block)
        if len(self._blocks) < MEAN_BLOCKS:
            return self
        self._rows.append(self._blocks)
        self._blocks = []
        self._state = warm_up(self._history(), self._dwell_s, 2 * (self._dwell_s + MOVE_S), self._marks)
        self._stated = self._now
        if not self._state.is_ready:
            return self
        self._context.event_log.say("start", "the unit has settled; positions may begin")
        self._choose_dwell()
        return self._then(self._context)

    def interrupted(self) -> Stage:
        """Start again: a device that was switched off warms up again."""
        return WarmUpStage(self._context, self._then)

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed: the noise is measured in the last ones."""
        rows = [*self._rows[-NOISE_ROWS:], self._blocks]
        return next((row[0].first for row in rows if row), None)

    def skipped(self) -> Stage:
        """Begin without: the drift seen is recorded and widens the sigmas."""
        context, history = self._context, self._history()
        try:
            found = unsettled_bias(history, context.checklist.remaining_s(), self._marks)
        except ValueError as error:
            context.event_log.say("rejected", f"not yet: {error}")
            return self
        gyro_deg_h = _deg_h(float(np.max(found.gyro)), history.gyro[-1])
        accel_g = 0.0
        if found.accel is not None and history.accel is not None:
            accel_g = float(np.max(found.accel) / np.max(np.abs(history.accel)))
        context.recorder.set_unsettled(gyro_deg_h, accel_g)
        text = f"warm-up was skipped: biases may drift by {gyro_deg_h:.2g} deg/h and {accel_g * UG_PER_G:.2g} ug"
        context.event_log.say("", f"{text}; this is recorded, and uncertainties increase")
        return self._then(context)

    def shown(self) -> dict[str, Any]:
        warm = WarmUpView(seconds=self._now - (self._began or self._now))
        if self._state is not None:
            warm = warm.model_copy(update=self._figures(self._state))
        warm = warm.model_copy(update={"note": self._hint or waits_for(warm)})
        return {
            "stage": "warm_up", "warm_up": warm, "line": "leave the cube at rest on the surface plate",
            "hint": self._hint,
        }  # fmt: skip

    def _figures(self, state: WarmUpState) -> dict[str, object]:
        left = None if state.left_s is None else state.left_s - (self._now - self._stated)
        is_known = left is not None and left >= MIN_SHOWN_LEFT_S  # else it is over, and goes on
        shown: dict[str, object] = {
            "left_s": left if is_known else None,
            "temperature_rate_c_min": _per_minute(state.temperature_rate),
            "temperature_limit_c_min": _per_minute(state.temperature_limit),
        }
        ratio = np.abs(state.gyro_drift / state.gyro_limit)
        if np.isfinite(ratio).all():
            worst, rest = int(np.argmax(ratio)), _mean_rate(self._rows[-1])[:3]
            shown["gyro_drift_deg_h"] = _deg_h(abs(float(state.gyro_drift[worst])), rest)
            shown["gyro_limit_deg_h"] = _deg_h(float(state.gyro_limit[worst]), rest)
        return shown

    @property
    def _dwell_s(self) -> float:
        return max((s.seconds for s in self._context.checklist.steps if isinstance(s, Dwell)), default=100.0)

    def _history(self) -> IntervalMeans:
        noise = np.maximum(self._context.gate.stillness.noise, MIN_VARIANCE) * TICKS_PER_BLOCK
        std = np.sqrt(noise / MEAN_BLOCKS + 1 / (6 * MEAN_BLOCKS**2))
        rates = np.array([_mean_rate(row) for row in self._rows]).reshape(-1, 6)
        stds = np.tile(std, (len(rates), 1))
        return IntervalMeans(
            t=np.array([row[-1].ends for row in self._rows]),
            gyro=rates[:, :3], gyro_std=stds[:, :3], accel=rates[:, 3:], accel_std=stds[:, 3:],
            temperature=np.array([np.mean([b.temperature for b in row]) for row in self._rows]),
        )  # fmt: skip

    def _choose_dwell(self) -> None:
        """Let the dwells be as long as the noise and the sigma wanted ask for."""
        context, wanted = self._context, self._context.bench.bias_std
        if wanted is None:
            return
        blocks = [block for row in self._rows[-NOISE_ROWS:] for block in row]
        recorded = series_of_runs(context.feed.buffer, runs_of_blocks(blocks, None), context.feed.period)
        noise = np.array([each.noise for each in triad_estimates(recorded.accel, recorded)])
        k = np.full(3, float(np.max(np.abs(blocks[-1].rate[3:]))))
        found = dwell_seconds(noise, k, wanted)
        context.set_dwell(found.seconds)
        wish = "" if found.is_reached else f", {wanted * UG_PER_G:.2g} ug cannot be reached"
        text = f"each dwell lasts {found.seconds:.0f} s, for a bias known to {found.bias_std_g * UG_PER_G:.2g} ug"
        context.event_log.say("", text + wish)


def waits_for(warm: WarmUpView) -> str:
    """Say what a warm-up waits for, in numbers that a person reads."""
    drift, limit = warm.gyro_drift_deg_h, warm.gyro_limit_deg_h
    if drift is None or limit is None:
        return "measuring the drift of the gyros"
    if drift > limit:
        wanted = f"waiting until the gyro drift is below {rounded(limit, limit)} deg/h"
        return f"{wanted}, now {rounded(drift, limit)} deg/h"
    rate, most = warm.temperature_rate_c_min, warm.temperature_limit_c_min
    if rate is not None and most is not None and abs(rate) > most:
        wanted = f"waiting until the temperature rate is below {rounded(most, most)} °C/min"
        return f"{wanted}, now {rounded(abs(rate), most)} °C/min"
    return f"the gyro drift is below {rounded(limit, limit)} deg/h: confirming"


def _per_minute(per_second: float | None) -> float | None:
    return None if per_second is None else 60 * per_second


def _mean_rate(row: Sequence[Block]) -> FloatArray:
    """Return the mean count rate (6,) [count/s] of some blocks."""
    rate: FloatArray = np.mean([block.rate for block in row], axis=0)
    return rate


def _deg_h(count_rate: float, rest: FloatArray) -> float:
    """Return a gyro's count rate in deg/h, roughly: the Earth's is most of what they count at ``rest`` (3,)."""
    k = float(np.linalg.norm(rest)) / EARTH_RATE
    return float(np.degrees(count_rate / k)) * DEG_H_PER_DEG_S
