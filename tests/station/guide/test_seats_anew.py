"""Seats that stand are judged anew: a crumb under an earlier seat is found, and who was accused for it cleared."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from station.files.campaign_folder.campaign_schema import CampaignTable, read_campaign_toml
from station.files.campaign_folder.notes import write_tables
from station.results.kept_tilted_dwells import doubt_of
from station.stream.recorder import accepted_step_writer
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def tilt(position: int, deg: float) -> str:
    """Return a tilt of the face that is up: about y where that is x, else about x."""
    return f"0 {deg} 0" if position <= 4 else f"{deg} 0 0"


def placed(guided: GuideRig, positions: tuple[int, ...], crumbs: dict[int, float]) -> None:
    """Place and accept positions, some of them on a crumb that tilts them by so much [deg]."""
    for position in positions:
        before = guided.view.step(f"dwell_{position:02d}").attempts
        guided.hands(f"place {position} 8 {tilt(position, crumbs.get(position, 0.0))}")
        guided.run(lambda v, p=position, n=before: v.step(f"dwell_{p:02d}").attempts > n)


def guide(rig: Make, *positions: int) -> GuideRig:
    return rig(dwells(*positions, seconds=20.0), replace(Truth.example(2), accel_k=np.full(3, 1e5)))


def tables_of(guided: GuideRig) -> CampaignTable:
    return read_campaign_toml(guided.folder)[0]


def twice_off(guided: GuideRig, position: int, tilt_deg: float = 0.0) -> None:
    guided.hands(f"place {position} 8 {tilt(position, tilt_deg)}")
    guided.run(lambda v: "not seated" in v.events[-1].text)
    placed(guided, (position,), {position: tilt_deg})


def again(guided: GuideRig, position: int, tilt_deg: float = 0.0) -> None:
    guided.obey("redo", step=f"dwell_{position:02d}")
    placed(guided, (position,), {position: tilt_deg})


@pytest.mark.parametrize("is_resumed", [False, True])
def test_a_clean_seat_is_cleared_once_the_crumb_before_it_is_wiped_off(rig: Make, is_resumed: bool) -> None:
    guided = guide(rig, 1, 2, 3, 4, 5, 6)
    placed(guided, (1, 2, 3, 4, 5), {5: 1.2})
    twice_off(guided, 6)
    assert "position 5 and position 6" in doubt_of(tables_of(guided))
    assert guided.view.wanted == "dwell_05"
    if is_resumed:
        guided.resume()
        guided.obey("redo", step="dwell_05")
    placed(guided, (5,), {})
    assert guided.context.badly_seated == set()
    assert "position 6 sat well" in guided.texts[-1]
    assert not doubt_of(tables_of(guided))


class KilledError(Exception):
    """Nothing was done after this."""


def test_a_kill_once_the_step_is_on_the_disk_loses_no_mark(rig: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guided = guide(rig, 1, 2, 3, 4, 5, 6)
    placed(guided, (1, 2, 3, 4, 5), {5: 1.2})
    guided.hands("place 6 8")
    guided.run(lambda v: "not seated" in v.events[-1].text)

    def written_and_killed(folder: Path, tables: CampaignTable) -> None:
        write_tables(folder, tables)
        raise KilledError

    monkeypatch.setattr(accepted_step_writer, "write_tables", written_and_killed)
    guided.hands("place 6 8")
    with pytest.raises(KilledError):
        guided.run(guided.done(6))
    monkeypatch.undo()
    guided.resume()
    assert guided.context.badly_seated == {"dwell_05", "dwell_06"}
    again(guided, 5)
    assert guided.context.badly_seated == set()


def test_what_stays_off_is_not_asked_for_for_ever(rig: Make) -> None:
    guided = guide(rig, 1, 2, 3, 4)
    placed(guided, (1, 2, 3), {})
    twice_off(guided, 4, 0.3)
    placed(guided, (3,), {})
    assert guided.context.badly_seated == {"dwell_04"}
    again(guided, 4, 0.3)
    assert [step.name for step in guided.view.steps if step.state == "redo"] == ["dwell_01", "dwell_02"]
    placed(guided, (1, 2), {})  # it might be they that tell of the slab what is wrong
    assert guided.context.badly_seated == {"dwell_03", "dwell_04"}
    assert guided.guide.is_complete
    assert "position 3 and position 4" in doubt_of(tables_of(guided))
