"""Tests against simulated devices. The program is `Reader`; yours may be anything that opens a port."""

from contextlib import closing

import pytest

from drivers.address_parsing import parse_device_url
from drivers.framing import Decoder
from drivers.ports import open_port, wire_of
from procedures.counts.sample_records import joined_blocks


class Reader:
    def __init__(self, url):
        self.port, self.decoder = open_port(url), Decoder(wire_of(parse_device_url(url)))

    def take(self, samples):
        blocks = [self.decoder.feed(b"")]
        while sum(len(block) for block in blocks) < samples:
            blocks.append(self.decoder.feed(self.port.read(2000)))
        return joined_blocks(blocks)

    def close(self):
        self.port.close()


def test_the_truth_is_in_the_counts(simulated_imu):
    got = Reader(simulated_imu.url).take(500)  # it stands in position 1: x up
    per_second = got.accel[:, 0].mean() / simulated_imu.truth.sample_period_s
    assert per_second == pytest.approx(simulated_imu.truth.accel_k[0], rel=0.01)  # count/(g s), at 1 g


@pytest.mark.simulated_imu(
    hold=True, faults=[{"kind": "lost", "at_s": 2, "count": 3}, {"kind": "bad_crc", "at_s": 4}]
)
def test_faults_at_set_times(simulated_imu):
    reader = Reader(simulated_imu.url)
    simulated_imu.hands.go()  # from here on no byte is missed
    reader.take(300)
    assert reader.decoder.counters.counter_jumps == 2
    assert reader.decoder.counters.bad_crc == 1


@pytest.mark.simulated_imu(transport="tcp", format="stim300")
def test_a_fault_now(simulated_imu):
    with closing(Reader(simulated_imu.url)) as reader:
        reader.take(100)
        simulated_imu.plant("bad_crc", count=4)
        while reader.decoder.counters.bad_crc < 4:
            reader.take(100)


@pytest.mark.simulated_imu(hold=True)
def test_hands_move_it_in_device_time(simulated_imu):
    reader, hands = Reader(simulated_imu.url), simulated_imu.hands
    hands.rest(3)
    done = hands.place(3, 5)  # x down, 5 s under way, then it settles
    hands.go()
    got = reader.take(1000)
    assert all(got.accel[got.device_time < 3, 0] > 0)
    assert all(got.accel[got.device_time > done, 0] < 0)


FORMATS = [pytest.param(name, marks=pytest.mark.simulated_imu(format=name)) for name in ("rawimusx", "kvh1750")]


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_that_we_support(simulated_imu, name):
    assert len(Reader(simulated_imu.url).take(50)) >= 50


@pytest.mark.simulated_imu(truth={"latitude_deg": 48.1}, speed=20)
@pytest.mark.simulated_gnss(autopilot={"system": 5}, transport="tcp")
def test_a_receiver_beside_the_imu(simulated_imu, simulated_gnss):
    from drivers.mavlink.gnss_fixes import MavlinkDecoder  # or your own

    imu, decoder, fixes = Reader(simulated_imu.url), MavlinkDecoder(), []
    with closing(open_port(simulated_gnss.url)) as link:
        while len(fixes) < 3:
            imu.take(1)  # one clock for both: it goes on while the IMU is read
            fixes += [each for each in decoder.feed(link.read(4096), 0) if hasattr(each, "latitude")]
    assert decoder.system == 5
    assert fixes[0].latitude == pytest.approx(0.8395, abs=1e-4)  # rad


@pytest.mark.simulated_camera(camera={"width": 160, "height": 120})
def test_a_camera_whose_images_are_cut(simulated_camera):
    from drivers.camera import CameraDecoder  # or OpenCV, from simulated_camera.url without "camera:"

    decoder, images = CameraDecoder(), []
    with closing(open_port(simulated_camera.url)) as port:
        while decoder.counters.cut < 3:
            images += decoder.feed(port.read(65536), host_ns=0)
            if len(images) == 2:
                simulated_camera.plant("cut", seconds=60)
    assert images[1].device_ns > images[0].device_ns  # the camera's own clock, ns
