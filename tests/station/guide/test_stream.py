"""The stream may fail; the person is never hurried, and nothing is accepted across a failure."""

from collections.abc import Callable

import pytest

from drivers.errors import LinkSilent
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from station.files.campaign_folder.campaign_reading import read_campaign
from station.guide.campaign.accepted_steps import read_accepted_steps
from station.stream.connected_unit import UnitChanged
from tests.refusals import refused
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def test_a_silent_stream_is_reported_once_and_the_dwell_begins_again(rig: Make) -> None:
    guided = rig(dwells(1, seconds=20.0))
    guided.run(lambda v: v.accepted_s >= 10)
    for _ in range(3):
        guided.guide.stream_failed(LinkSilent("port", 2.0, None))
    view = guided.view
    assert not view.link.is_live
    assert "port" in view.hint
    assert [e.sound for e in view.events].count("rejected") == 2  # the port, and the dwell that it broke
    guided.guide.stream_is_back()
    guided.run(guided.done(1))
    assert guided.view.link.is_live


def test_another_unit_is_refused_and_none_of_its_samples_are_used(rig: Make) -> None:
    guided = rig(dwells(1, 2, seconds=20.0))
    guided.run(lambda v: v.accepted_s >= 10)
    own = guided.source.device
    guided.source.device = ByteDevice(Truth.example(2), 1, "counts")
    with refused(UnitChanged, ErrorCode.WRONG_UNIT, found="SIM-2", expected="SIM-1"):
        guided.run(guided.done(1))
    guided.feed.reset()
    guided.guide.stream_failed(UnitChanged("port", "SIM-2", "SIM-1"))
    guided.source.device = own
    guided.feed.reset()
    guided.guide.stream_is_back()
    guided.run(guided.done(1))
    assert any("the data stream was interrupted" in text for text in guided.texts)


@pytest.mark.proof
def test_nobody_is_hurried(rig: Make) -> None:
    guided = rig(dwells(1, 2))
    guided.run(guided.done(1))
    view = guided.rest(3600)
    assert view.stage == "place"
    guided.hands("place 2 8")
    guided.run(guided.done(2))


def test_a_unit_switched_off_and_on_says_so_warms_up_and_marks_what_follows(rig: Make) -> None:
    guided = rig(dwells(1, 2, 3, seconds=10.0), faults=[Fault("restart", at_s=400.0, seconds=6.0)], warms_up=True)
    guided.run(guided.done(1))
    guided.hands("place 2 8")
    guided.run(guided.done(2))
    view = guided.run(lambda v: any("switched off and on" in event.text for event in v.events))
    assert view.events[-1].text.endswith("it must warm up again")
    assert view.stage == "warm_up"
    assert guided.context.accepted_dwells == {}
    guided.hands("place 3 8")
    guided.run(guided.done(3))
    assert [dwell.turn_on for dwell in read_campaign(guided.folder).tables.dwell] == [None, None, 2]
    assert read_accepted_steps(guided.folder).turn_on == 2
    assert [each.position for each in read_accepted_steps(guided.folder).dwells] == [3]


def test_a_port_that_was_away_alone_is_no_power_cycle(rig: Make) -> None:
    guided = rig(dwells(1, 2, seconds=10.0), faults=[Fault("unplug", at_s=40.0, seconds=6.0)])
    guided.run(guided.done(1))
    guided.rest(60)
    assert not any("switched off" in text for text in guided.texts)
    assert guided.context.turn_on == 1
