"""What accepted steps leave for later ones: count rates of dwells, closure of turns, recorded free attitudes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.bench.seating_check import PositionRates, TurnCounts
from procedures.campaign.campaign import Campaign, TurnRecord
from procedures.campaign.observations import turn_totals
from procedures.campaign.plan_steps import Dwell, FreePosition, Soak, Turn
from procedures.counts.count_rate import RateEstimate, estimate_channels
from procedures.counts.sample_records import CountSeries
from procedures.frames import AXES
from procedures.planning.campaign_design import Placement
from procedures.positions import face_of
from procedures.twelve_positions.rotation_tilt import turn_rests
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import StepTable
from station.guide.campaign.checklist import is_free
from station.results.plan_document import placements_in
from station.stream.live.stillness import series_as_counts
from station.stream.live.stream_trouble import switched_on_again
from station.stream.recorder.accepted_step_writer import step_of


@dataclass(frozen=True, slots=True, eq=False)
class AcceptedDwell:
    """Count rates (3,) and 1 sigma (3,) [count/s], raw, of a dwell."""

    step: Dwell
    accel: FloatArray
    accel_std: FloatArray
    gyro: FloatArray
    gyro_std: FloatArray

    @property
    def position(self) -> int:
        """The position, 1..24."""
        return self.step.position

    @property
    def face(self) -> str:
        """The face that was up."""
        return face_of(self.position)


def accepted_dwell(step: Dwell, series: CountSeries, accel: Sequence[RateEstimate] | None = None) -> AcceptedDwell:
    """Estimate the rates of a dwell; ``accel`` are the accelerometers', where they are known already."""
    accel = triad_estimates(series.accel, series) if accel is None else accel
    gyro = triad_estimates(series.gyro, series)
    return AcceptedDwell(step, *rates_and_sigmas(accel), *rates_and_sigmas(gyro))


def rates_and_sigmas(found: Sequence[RateEstimate]) -> tuple[FloatArray, FloatArray]:
    """Return the rates (3,) and their sigmas (3,)."""
    return np.array([each.rate for each in found]), np.array([each.std for each in found])


def triad_estimates(samples: IntArray | None, series: CountSeries) -> list[RateEstimate]:
    """Estimate the three channels of a triad from counts, ``samples`` (n, 3)."""
    assert samples is not None, "the station's own recordings contain both triads"
    channels = [[samples[:, i]] for i in range(3)]
    return [found[0] for found in estimate_channels(channels, series.period, [series.starts], [series.t])]


SURE_REST_S = 2.0  # of rest before a turn that surely were


@dataclass(frozen=True, slots=True, eq=False)
class AcceptedSteps:
    """What accepted steps leave, by step name where not stated otherwise.

    ``dwells`` as accepted; ``turns`` in the order they were done; ``seconds`` how long each step is;
    ``free_attitudes`` by the accelerometers' count rates (3,); ``badly_seated`` the steps whose seat is bad;
    ``placements`` in the order they were done, as a planned campaign has them;
    ``turn_on`` for which time, from 1, the unit was switched on, and ``last_s`` its last clock reading;
    ``dwells`` and ``turn_rests``, the accelerometers' rates at rest about turns, are of that one, ``earlier``
    dwells, which sat well, of those before it.
    """

    dwells: tuple[AcceptedDwell, ...] = ()
    turns: Mapping[str, TurnCounts] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    free_attitudes: Mapping[str, FloatArray] = field(default_factory=dict)
    badly_seated: frozenset[str] = frozenset()
    placements: tuple[tuple[str, Placement], ...] = ()
    turn_on: int = 1
    last_s: float | None = None
    earlier: tuple[tuple[AcceptedDwell, int], ...] = ()
    turn_rests: Mapping[str, PositionRates] = field(default_factory=dict)


NO_ACCEPTED_STEPS = AcceptedSteps()


def after_pause(done: AcceptedSteps, now_s: float, elapsed_s: float) -> AcceptedSteps:
    """Return what is left of it where the device's clock says ``now_s``, ``elapsed_s`` after the last step.

    Nothing of the dwells if it was switched off and on: they held other biases.
    """
    if done.last_s is None or not switched_on_again(done.last_s, now_s, elapsed_s):
        return done
    well = [(each, done.turn_on) for each in done.dwells if each.step.name not in done.badly_seated]
    earlier, on = (*done.earlier, *well), done.turn_on + 1
    return replace(done, dwells=(), turn_on=on, last_s=None, earlier=earlier, turn_rests={})


def read_accepted_steps(folder: Path) -> AcceptedSteps:
    """Return what the accepted steps leave for those after them."""
    folder_read = read_campaign(folder)
    loaded = folder_read.campaign
    tables = {one.file: one for one in folder_read.tables.steps()}
    turn_on = max((getattr(one, "turn_on", None) or 1 for one in tables.values()), default=1)
    known = [
        (accepted_dwell(_dwell(tables[d.name]), series_as_counts(d.series)), d.turn_on) for d in loaded.dwells
    ]
    before = [dwell for dwell, on in known if on == turn_on]
    turns = {_name(turn): turn_seen(turn, loaded.fixture.C_sb) for turn in loaded.turns}
    seconds, free_attitudes = dict[str, float](), dict[str, FloatArray]()
    for one in folder_read.steps:
        if (step := step_of(one.table)) is None or one.data is None:
            continue
        series = one.data.series
        seconds[step.name] = len(series) * series.period
        if isinstance(step, FreePosition | Soak) and is_free(step):
            free_attitudes[step.name] = np.asarray(series_as_counts(series).accel).mean(axis=0) / series.period
    bad = frozenset(_dwell(one).name for one in folder_read.tables.dwell if one.number and one.kept_seat_rad)
    of_now = [one for one in folder_read.steps if (getattr(one.table, "turn_on", None) or 1) == turn_on]
    last = max((float(one.data.series.t[-1]) for one in of_now if one.data is not None), default=None)
    made = ((step_of(tables[name]), placement) for name, placement in placements_in(loaded))
    placements = tuple((step.name, placement) for step, placement in made if step is not None)
    earlier = tuple((dwell, on) for dwell, on in known if on != turn_on and dwell.step.name not in bad)
    rests = _turn_rests(loaded, turn_on)
    return AcceptedSteps(
        tuple(before), turns, seconds, free_attitudes, bad, placements, turn_on, last, earlier, rests
    )


def _turn_rests(loaded: Campaign, turn_on: int) -> dict[str, PositionRates]:
    """Return the rates at rest before and after the turns of a turn-on, their mean, by step."""
    turns = [turn for turn in turn_totals([loaded], np.zeros(3)) if turn.record.turn_on == turn_on]
    found = dict[str, PositionRates]()
    if (rests := turn_rests(turns)) is None:
        return found
    for i, (_, rest) in list(enumerate(rests.rests))[::2]:
        turn = next(turn.record for turn in turns if turn.record.name == rest.name)
        std = np.sqrt(np.sum(rests.std[i : i + 2] ** 2, axis=0)) / 2
        found[_name(turn)] = turn.start_position, rests.rate[i : i + 2].mean(axis=0), std
    return found


def _dwell(table: StepTable) -> Dwell:
    step = step_of(table)
    assert isinstance(step, Dwell)  # it has a position
    return step


def _name(turn: TurnRecord) -> str:
    return Turn(turn.axis, turn.direction, round(turn.revolutions), turn.start_position, 0.0).name


def turn_seen(turn: TurnRecord, C_sb: FloatArray) -> TurnCounts:
    """Return a turn's counts as `RotationDetector` saw them, less those at rest; ``C_sb`` (3, 3): cube to IMU."""
    series = series_as_counts(turn.series)
    samples = np.asarray(series.gyro) @ C_sb[:, AXES.index(turn.axis)]
    n = max(round(SURE_REST_S / series.period), 2)
    rest, total = samples[:n], float(np.sum(samples - samples[:n].mean()))
    angle = 2 * np.pi * turn.revolutions
    noise = float(rest.std(ddof=1) / np.sqrt(n)) * len(samples) / abs(total) * angle
    return TurnCounts(turn.direction, abs(total) / turn.revolutions, angle, noise)
