from dataclasses import replace

import numpy as np

from procedures.campaign.campaign import SequenceRecord
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.free_positions.gyroscopes_from_moves import SegmentedSequence
from procedures.free_positions.norm_fit import choose_rests
from procedures.free_positions.rest_detection import rests_of, scatter_level, whole_seconds
from tests.procedures.free_units import sequence, unit

PER_S = 100


def recording(seed: int = 1, rests: int = 20) -> SequenceRecord:
    rng = np.random.default_rng(seed)
    accel, gyro = unit(rng, 400.0, 1e-2, lower=True), unit(rng, 80.0, 0.1)
    return sequence(rng, accel, gyro, rests=rests, accel_noise=1e-3, gyro_noise=0.1)


def test_every_rest_is_found_and_nothing_of_a_move_is_in_it() -> None:
    series = recording().series
    multiplier, found = choose_rests(scatter_level(series), 1.0)
    assert multiplier > 1
    assert len(found) == 20
    for i, rest in enumerate(found):
        assert 6 * PER_S * i <= rest.start
        assert rest.stop <= 6 * PER_S * i + 4 * PER_S + PER_S // 4  # a move begins softly
        assert rest.stop - rest.start > 2.5 * PER_S


def test_a_turn_about_the_vertical_that_the_accelerometers_cannot_see_ends_a_rest() -> None:
    rng, n = np.random.default_rng(2), 20 * PER_S
    gyro, accel = 0.1 * rng.standard_normal((n, 3)), 1e-3 * rng.standard_normal((n, 3)) + [0, 0, 1]
    gyro[8 * PER_S : 12 * PER_S, 2] += 20 * np.sin(np.linspace(0, np.pi, 4 * PER_S))
    series = RateSeries(np.arange(1, n + 1) / PER_S, gyro, accel, np.full(n, np.nan), 1 / PER_S)
    first, second = scatter_level(series).rests(3.0)
    assert first.stop <= 8 * PER_S
    assert second.start >= 12 * PER_S - PER_S // 2
    assert len(scatter_level(replace(series, gyro=None)).rests(3.0)) == 1


def test_a_gap_ends_a_rest_and_the_move_around_it_is_none() -> None:
    record = recording()
    series = replace(record.series, starts=np.array([0, 6 * PER_S + 2 * PER_S, 12 * PER_S + 5 * PER_S]))
    stretches = scatter_level(series).rests(3.0)
    assert not any(s.start < g < s.stop for s in stretches for g in series.starts[1:])
    record = replace(record, series=series)
    moves = SegmentedSequence(0, record, tuple(stretches), rests_of(record, stretches)).moves()
    assert not any(s.start <= g <= s.stop for _, s in moves for g in series.starts[1:])
    assert len(moves) == len(stretches) - 3


def test_counts_are_cut_as_rates_are() -> None:
    series = recording().series
    assert series.gyro is not None
    assert series.accel is not None
    gyro, accel = (np.round(50 * a).astype(np.int64) for a in (series.gyro, series.accel))
    counts = CountSeries(series.t, gyro, accel, series.temperature, series.period)
    stretches = scatter_level(counts).rests(3.0)
    rests = rests_of(SequenceRecord("s.csv", counts), stretches)
    assert len(rests) == 20
    assert rests[3].series.accel is not None
    assert np.array_equal(rests[3].series.accel, accel[stretches[3]])


def test_a_rest_has_the_auxiliary_channels_of_its_own_time() -> None:
    record = recording(rests=3)
    series = replace(record.series, extra={"aux_pressure": record.series.t.copy()})
    stretches = scatter_level(series).rests(3.0)
    for rest in rests_of(replace(record, series=series), stretches):
        assert rest.series.extra["aux_pressure"].tolist() == rest.series.t.tolist()


def test_seconds_are_counted_from_the_first_sample_whenever_that_was() -> None:
    for begin in (0.0, 100.7, 1e6 + 0.3):
        assert whole_seconds(begin + np.array([0.0, 0.9, 1.1, 1.9, 7.5])).tolist() == [0, 0, 1, 1, 7]
