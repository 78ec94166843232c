"""Images come out of a camera's bytes whole or not at all, however they come and whatever is wrong with them."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.camera import CameraDecoder, CameraImage
from drivers.camera.decoder import MAX_HEADER_BYTES, MAX_IMAGE_BYTES, part
from drivers.camera.jpeg import BrokenJpeg, jpeg_size
from tests.benchmarks.hostile_camera import ROWS, attack
from tests.drivers.camera.images import HEIGHT, WIDTH, jpegs, with_thumbnail

pytest.importorskip("cv2", reason="opencv is not installed")
IMAGES = jpegs()
STREAM = b"".join(part(jpeg, 100 + i / 20, 0.002) for i, jpeg in enumerate(IMAGES))
BARE = b"".join(IMAGES)  # a stream without any header


def decoded(data: bytes, cuts: tuple[int, ...] = ()) -> tuple[CameraDecoder, list[CameraImage]]:
    decoder, images = CameraDecoder(), list[CameraImage]()
    edges = [0, *sorted(cuts), len(data)]
    for number, (a, b) in enumerate(pairwise(edges)):
        images += decoder.feed(data[a:b], number * 10**9)
    return decoder, images


def jpegs_of(data: bytes) -> list[bytes]:
    return [image.jpeg for image in decoded(data)[1]]


def test_every_image_comes_with_the_senders_stamp_and_the_moment_it_was_taken() -> None:
    decoder, images = decoded(STREAM)
    assert [image.jpeg for image in images] == [*IMAGES]
    assert [image.device_ns for image in images] == [100_000_000_000 + i * 50_000_000 for i in range(4)]
    assert {image.host_ns for image in images} == {-2_000_000}
    counters = decoder.counters
    assert (counters.images, counters.skipped_bytes, counters.not_jpeg, counters.cut) == (4, 0, 0, 0)
    assert jpeg_size(IMAGES[0]) == (WIDTH, HEIGHT)


@given(st.lists(st.integers(0, len(STREAM)), max_size=12))
def test_it_does_not_matter_where_the_bytes_are_split(cuts: list[int]) -> None:
    whole, images = decoded(STREAM)
    split, same = decoded(STREAM, tuple(cuts))
    assert [(image.jpeg, image.device_ns) for image in images] == [(image.jpeg, image.device_ns) for image in same]
    assert whole.counters == split.counters


def test_byte_by_byte_an_image_has_the_time_of_its_first_byte() -> None:
    _, images = decoded(STREAM, tuple(range(1, len(STREAM))))
    assert [image.jpeg for image in images] == [*IMAGES]
    for image in images:
        at = STREAM.index(image.jpeg)
        assert at - 64 <= (image.host_ns + 2_000_000) / 1e9 <= at  # reads shorter than 64 bytes share a stamp
        assert image.came_ns == (at + len(image.jpeg) - 1) * 10**9


def test_a_read_that_ends_within_an_image_stamps_it_and_not_the_next() -> None:
    second = STREAM.index(IMAGES[1])
    _, images = decoded(STREAM, (second + 5,))
    assert [round(image.host_ns / 1e9) for image in images] == [0, 0, 1, 1]
    _, images = decoded(STREAM, (second,))
    assert [round(image.host_ns / 1e9) for image in images] == [0, 1, 1, 1]


@settings(max_examples=100)
@given(
    st.sampled_from([STREAM, BARE, STREAM.replace(b"Content-Length", b"X-Nothing")]),
    st.lists(
        st.tuples(
            st.integers(0, 2**16), st.sampled_from(["flip", "drop", "insert", "cut"]), st.binary(max_size=40)
        )
    ),
)
def test_damage_anywhere_never_raises_and_later_images_come_back(
    stream: bytes, damages: list[tuple[int, str, bytes]]
) -> None:
    spoilt = bytearray(stream)
    for at, kind, data in damages:
        at %= len(spoilt) + 1
        if kind == "drop":
            del spoilt[at : at + len(data)]
        elif kind == "cut":
            del spoilt[at:]
        elif kind == "insert":
            spoilt[at:at] = data
        else:
            spoilt[at : at + len(data)] = data
    later = jpegs(12, seed=1)  # a broken length of a segment leads 64 kB ahead at most, a padding further
    found = jpegs_of(bytes(spoilt) + b"".join(part(jpeg) for jpeg in later * 3))
    assert found[-1] == later[-1]


@given(st.integers(3, len(IMAGES[1]) - 1))
def test_an_image_that_was_cut_is_none_and_the_next_is_found(at: int) -> None:
    cut = b"--boundary\r\nContent-Type: image/jpeg\r\n\r\n" + IMAGES[1][:at]
    for header in (cut, cut.replace(b"image/jpeg", b"image/jpeg\r\nContent-Length: %d" % len(IMAGES[1]))):
        decoder, images = decoded(part(IMAGES[0]) + header + STREAM)
        assert [image.jpeg for image in images] == [IMAGES[0], *IMAGES]
        assert decoder.counters.cut == 1


@given(st.integers(20, len(IMAGES[1]) - 2), st.integers(1, 30))
def test_bytes_lost_within_an_image_show_by_its_length(at: int, count: int) -> None:
    whole = part(IMAGES[1])
    begin = whole.index(b"\xff\xd8") + at
    assert jpegs_of(whole[:begin] + whole[begin + count :] + STREAM)[-4:] == [*IMAGES]
    assert IMAGES[1][:at] + IMAGES[1][at + count :] not in jpegs_of(
        whole[:begin] + whole[begin + count :] + STREAM
    )


def test_a_stream_without_headers_gives_its_images_without_stamps() -> None:
    decoder, images = decoded(b"noise" + BARE)
    assert [image.jpeg for image in images] == [*IMAGES]
    assert images[0].device_ns is None
    assert decoder.counters.skipped_bytes == 5


def test_a_thumbnail_is_never_taken_for_the_image() -> None:
    large = with_thumbnail(IMAGES[0], IMAGES[1])
    assert jpegs_of(part(large)) == [large]
    broken = bytearray(part(large) + STREAM)
    broken[broken.index(b"\xff\xe1") + 2] ^= 0x40  # where the segment's length stands
    assert IMAGES[1] not in jpegs_of(bytes(broken))[:1]
    assert jpegs_of(bytes(broken))[-4:] == [*IMAGES]
    headless = part(large).replace(b"\r\n\r\n", b"\r\n", 1)
    assert jpegs_of(STREAM + headless + STREAM) == [*IMAGES, *IMAGES]


def test_parts_that_are_no_jpeg_are_counted() -> None:
    text = b"--b\r\nContent-Type: text/plain\r\nContent-Length: 5\r\n\r\nhello\r\n"
    decoder, images = decoded(text * 3 + STREAM)
    assert len(images) == 4
    assert (decoder.counters.not_jpeg, decoder.counters.skipped_bytes) == (3, 15)


@pytest.mark.parametrize("stamp", ["", "-1", "nan", "1e9", "12.3.4", "99999999999", "1.0000000001"])
def test_a_stamp_that_is_none_is_none(stamp: str) -> None:
    head = f"--b\r\nX-Timestamp: {stamp}\r\nX-Age: {stamp}\r\nContent-Length: {stamp}\r\n\r\n"
    [image] = decoded(head.encode() + IMAGES[0])[1]
    assert (image.device_ns, image.host_ns) == (None, 0)


def test_memory_is_bounded_whatever_comes() -> None:
    endless = b"--b\r\nContent-Type: image/jpeg\r\n\r\n" + IMAGES[0][:-2] + bytes(MAX_IMAGE_BYTES + 2**16)
    decoder = CameraDecoder()
    for at in range(0, len(endless), 2**16):
        decoder.feed(endless[at : at + 2**16], 0)
    assert decoder.counters.cut == 1
    assert len(decoder._data) <= MAX_HEADER_BYTES  # noqa: SLF001
    decoder.feed(b"\n\n" + b"a:b\n" * 10**5, 0)
    assert len(decoder._data) <= MAX_HEADER_BYTES  # noqa: SLF001
    assert len(decoder.feed(STREAM, 0)) == 4


def test_hostile_parts_neither_crash_nor_pass_for_images() -> None:
    got = attack(3000, 5, ROWS["with Content-Length"])
    assert (got.crashes, got.wrong) == (0, 0)
    assert got.lost <= got.intact // 1000
    assert attack(500, 5, ROWS["without headers"]).wrong > 0  # the test can see some


@pytest.mark.parametrize("data", [b"", b"\xff\xd8\xff\xd9", IMAGES[0][:-1], b"\xff\xd8\xff\xe0\x00\x01"])
def test_what_is_no_whole_jpeg_has_no_size(data: bytes) -> None:
    with pytest.raises(BrokenJpeg):
        jpeg_size(data)
