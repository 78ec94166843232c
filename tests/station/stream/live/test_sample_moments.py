from station.stream.live.sample_moments import SampleMoments


def test_samples_of_one_read_were_taken_one_after_another() -> None:
    moments = SampleMoments()
    reads = [(0.1, 1.0), (0.5, 1.0), (1.0, 1.0), (1.1, 2.003), (2.0, 2.003)]  # device time, read at [s]
    found = [moments.of(t, round(read * 1e9)) / 1e9 for t, read in reads]
    assert found[2:] == [1.0, 1.1, 2.0]
    moments.begin_anew()
    assert moments.of(0.0, 5 * 10**9) == 5 * 10**9
