"""Three single-axis gyros on three ports become one triad: joined by time, missing parts seen, all bytes kept."""

from collections.abc import Iterator
from threading import Event

import numpy as np
import pytest

from drivers.address_parsing import parse_device_url
from drivers.errors import BadDeviceUrl, LinkLost, PortNotFound
from drivers.framing import Decoder, sniff
from drivers.ports import open_port
from drivers.simulated.lines import PtyLine
from drivers.triad_port import TriadJoiner
from drivers.wire import FORMATS, triad
from procedures.counts.sample_records import CountBlock
from tests.patience import HANG_S

AXIS, WIRE = FORMATS["ch70"], FORMATS["triad"]
PERIOD = 0.0025


def frames(axis: int, first: int, n: int) -> bytes:
    """Return an axis' frames; each count says which sample it is."""
    gyro = np.zeros((n, 3), np.int64)
    gyro[:, 0] = np.arange(first, first + n) * 3 + axis
    nothing = np.zeros(n)
    block = CountBlock(
        np.arange(n), nothing, gyro, 0 * gyro, nothing + 20 + axis, np.zeros(n, np.int64), np.ones(n, np.bool_)
    )
    return AXIS.encode(block)


def joined(
    seconds: float, lost: dict[int, set[int]], *, ppm: tuple[float, float, float] = (0, 0, 0), size: int = 20
) -> tuple[TriadJoiner, CountBlock]:
    """Return what the joiner makes of three axes read ``size`` frames at a time, some frames lost."""
    joiner, rng, events = TriadJoiner(AXIS), np.random.default_rng(1), list[tuple[float, int, bytes]]()
    for axis in range(3):
        period, whole = PERIOD * (1 + ppm[axis] * 1e-6), frames(axis, 0, int(seconds / PERIOD) + size)
        for first in range(0, int(seconds / PERIOD), size):
            sent = [k for k in range(first, first + size) if k not in lost.get(axis, set())]
            arrival = 100 + (first + size) * period + 1e-4 * axis + rng.exponential(2e-4)
            if sent:
                events.append((arrival, axis, b"".join(whole[10 * k : 10 * k + 10] for k in sent)))
    decoder = Decoder(WIRE)
    stream = b"".join(joiner.feed(axis, at, data) for at, axis, data in sorted(events))
    block = decoder.feed(stream)
    assert isinstance(block, CountBlock)
    assert decoder.counters.skipped_bytes == 0
    return joiner, block


def which(block: CountBlock) -> np.ndarray:
    """Return which sample each axis' share is of, (n, 3)."""
    return (block.gyro - np.arange(3)) // 3


def test_shares_of_the_same_moment_come_together() -> None:
    joiner, block = joined(8.0, {})
    samples = which(block)
    assert len(block) > 4.5 / PERIOD  # 3 s to learn the period
    assert (samples == samples[:, :1]).all()
    assert (np.diff(samples[:, 0]) == 1).all()
    assert (np.diff(block.counter) == 1).all()
    assert np.diff(block.device_time) == pytest.approx(PERIOD, rel=0.3)
    assert joiner.missing == 0
    assert block.healthy.all()
    assert block.temperature == pytest.approx(21.0)


def test_a_share_that_is_lost_is_a_gap_and_the_axes_are_in_step_again() -> None:
    joiner, block = joined(16.0, {1: {2600, 2601}, 0: {4000}})
    samples = which(block)
    out = (samples != samples[:, :1]).any(axis=1)
    assert out.any() or joiner.missing  # for up to a second, until the loss is certain
    late = samples[:, 0] > 4000 + 2 / PERIOD
    assert late.sum() > 1 / PERIOD
    assert not out[late].any()
    assert not out[samples[:, 0] < 2590].any()
    assert out.sum() < 2 * 1.6 / PERIOD  # three half seconds each
    assert 1 <= joiner.missing <= 6
    assert (np.diff(block.counter) > 1).any()
    assert (np.diff(block.counter) - 1).sum() == joiner.missing  # each is a number that no sample has


def test_gyros_on_clocks_of_their_own_stay_within_a_sample() -> None:
    joiner, block = joined(15.0, {}, ppm=(0, 400, -300), size=8)
    share = which(block)
    true = np.array([1, 1 + 400e-6, 1 - 300e-6]) * PERIOD * share
    assert np.abs(true - true[:, :1]).max() < PERIOD
    assert joiner.missing <= 4
    assert (np.diff(block.device_time) > 0).all()


def test_an_axis_that_falls_silent_gives_no_sample_but_gaps() -> None:
    joiner, block = joined(12.0, {2: set(range(2400, 3600))})
    assert joiner.missing > 1100
    samples = which(block)
    assert not ((samples[:, 0] > 2410) & (samples[:, 0] < 3590)).any()


@pytest.fixture
def lines() -> Iterator[list[PtyLine]]:
    lines = [PtyLine() for _ in range(3)]
    for line in lines:
        line.plug()
    yield lines
    for line in lines:
        line.unplug()


def url_of(lines: list[PtyLine]) -> str:
    return "triad:?" + "&".join(f"{axis}={line.address}" for axis, line in zip("xyz", lines, strict=True))


def test_three_ptys_are_read_and_every_byte_is_kept(lines: list[PtyLine]) -> None:
    port, stream = open_port(url_of(lines), timeout_s=HANG_S), b""
    sent = [b"", b"", b""]
    for k in range(30):
        for axis in (2, 0, 1):
            data = frames(axis, k, 1) + (b"\x00noise" if k == 7 else b"")
            lines[axis].write(data, Event())
            sent[axis] += data
    while len(stream) < 36 * 3 * 2 or sum(map(len, kept(stream))) < sum(map(len, sent)):
        piece = port.read(65536)
        assert piece, "nothing more came"
        stream += piece
    assert kept(stream) == sent
    assert sniff(stream)[:1] == [] or sniff(stream)[0].format == "triad"
    lines[1].unplug()
    with pytest.raises(LinkLost):  # what was on its way may come first
        _ = [port.read(65536) for _ in range(5)]
    port.close()
    port.close()


def kept(stream: bytes) -> list[bytes]:
    """Return the axes' own bytes in a triad's stream."""
    found = [b"", b"", b""]
    for at in range(0, len(stream), 36):
        if stream[at + 2] == 2:
            (row,) = np.frombuffer(stream[at : at + 36], triad.READ)
            found[row["axis"]] += row["data"].tobytes()[: row["size"]]
    return found


def test_where_one_port_is_missing_the_others_are_given_back(lines: list[PtyLine]) -> None:
    wrong = url_of(lines).rpartition("=")[0] + "=serial:///dev/ttyNOPE"
    with pytest.raises(PortNotFound, match="ttyNOPE"):
        open_port(wrong)
    open_port(url_of(lines)).close()


def test_a_triads_address_names_three_ports_and_what_is_common() -> None:
    url = "triad:?x=serial:///dev/a&y=serial:///dev/b&z=tcp://h:5&format=ch70&baud=230400"
    address = parse_device_url(url)
    assert address.format == "triad"
    assert [each.name for each in address.axes] == ["/dev/a", "/dev/b", "h:5"]
    assert {each.format for each in address.axes} == {"ch70"}
    assert (address.axes[0].baud, address.axes[0].parity) == (230400, "E")
    for wrong, named in (
        ("triad:?x=serial:///dev/a&y=serial:///dev/b", "no z"),
        ("triad:?x=serial:///dev/a&y=serial:///dev/b&z=serial:///dev/a", "three different"),
        ("triad:?x=serial:///dev/a&y=serial:///dev/b&z=replay:f", "a serial line or a TCP"),
        ("triad:?x=serial:///dev/a&y=serial:///dev/b&z=serial:///dev/c&format=counts", "one of ch70"),
    ):
        with pytest.raises(BadDeviceUrl, match=named):
            parse_device_url(wrong)
