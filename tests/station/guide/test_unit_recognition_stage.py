"""A unit whose wire says no serial number is known by its counts, and then it is asked."""

from collections.abc import Callable

import pytest

from station.files.campaign_folder.notes import UnitRecord, read_note, write_note
from station.guide.guide import Guide
from station.stream.recorder.connected_unit import UnitChanged
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def begun(rig: Make) -> GuideRig:
    """Return a campaign with one dwell, which keeps how the unit looked in it."""
    guided = rig(dwells(1, 2))
    unit = UnitRecord(model="FOG", serial="7", serial_from_wire=False, period=0.02)
    write_note(guided.folder, unit)
    guided.run(guided.done(1))
    return guided


def gone_on(guided: GuideRig) -> None:
    record = read_note(guided.folder, UnitRecord)
    assert record is not None
    assert record.rate is not None
    guided.guide = Guide(guided.context, warms_up=False, unsure=record)


def test_the_same_unit_looks_the_same_and_is_still_asked_for(rig: Make) -> None:
    guided = begun(rig)
    gone_on(guided)
    view = guided.run(lambda v: v.question is not None)
    assert "its rates and noise are those of the first dwell" in view.question.text
    guided.rest(30)
    assert guided.view.done == 1  # nothing is recorded before the answer
    guided.obey("answer", key="y")
    guided.hands("place 2 8")
    guided.run(guided.done(2))


def test_another_unit_is_told_apart_and_no_ends_it(rig: Make) -> None:
    guided = begun(rig)
    record = read_note(guided.folder, UnitRecord)
    assert record is not None
    assert record.rate is not None
    rate = [value * 1.02 if i == 3 else value for i, value in enumerate(record.rate)]
    guided.guide = Guide(guided.context, warms_up=False, unsure=record.model_copy(update={"rate": tuple(rate)}))
    view = guided.run(lambda v: v.question is not None)
    assert "unlike the campaign's first dwell: accelerometer x by" in view.question.text
    with pytest.raises(UnitChanged):
        guided.obey("answer", key="n")
