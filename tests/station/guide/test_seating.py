"""Seats: debris under the cube is found, a kept tilt is marked, and seats are judged again when one is redone."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import CampaignTable, read_campaign_toml
from station.files.campaign_folder.plan_file import write_tables
from station.results.contradictory_dwells import kept_tilt_warning
from station.stream.recorder import accepted_step_writer
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


@pytest.mark.parametrize("how", ["again", "kept"])
def test_a_seat_that_comes_back_or_is_kept_is_taken(rig: Make, how: str) -> None:
    truth = replace(Truth.example(2), accel_k=np.full(3, 1e5))
    guided = rig(dwells(1, 2, 3, 4, seconds=40.0), truth)
    for count, position in enumerate((1, 2, 3), start=1):
        guided.hands(f"place {position} 8")
        guided.run(guided.done(count))
    guided.hands("place 4 8 0 0.03 0")
    guided.run(lambda v: any("not seated" in e.text for e in v.events))
    if how == "again":
        guided.hands("place 4 8 0 0.03 0")
    else:
        guided.execute("keep_seating")
    guided.run(guided.done(4))


def on_debris(rig: Make, tilt_deg: float) -> GuideRig:
    """Positions 1 to 3, then 4 tilted, up to where it is said."""
    truth = replace(Truth.example(2), accel_k=np.full(3, 1e5))
    guided = rig(dwells(1, 2, 3, 4, 5, 6, 7, 8, seconds=20.0), truth)
    for count, position in enumerate((1, 2, 3), start=1):
        guided.hands(f"place {position} 8")
        guided.run(guided.done(count))
    guided.hands(f"place 4 8 0 {tilt_deg} 0")
    guided.run(lambda v: any("not seated" in e.text for e in v.events))
    return guided


@pytest.mark.parametrize("is_resumed", [False, True])
def test_a_kept_tilted_seat_condemns_no_good_seat_after_it_also_after_a_resume(
    rig: Make, is_resumed: bool
) -> None:
    guided = on_debris(rig, 0.3)
    guided.execute("keep_seating")
    view = guided.run(lambda v: v.question is not None)
    assert "tilted by 0.30 deg" in view.question.text
    guided.execute("answer", key="y")
    guided.run(guided.done(4))
    [kept] = [d.kept_seat_rad for d in read_campaign_toml(guided.folder)[0].dwell if d.position == 4]
    assert np.degrees(np.hypot(*kept)) == pytest.approx(0.3, abs=0.01)
    if is_resumed:
        guided.resume()
    reported = max((event.number for event in guided.view.events), default=0)
    for count, position in enumerate((5, 6, 7, 8), start=5):
        guided.hands(f"place {position} 8")
        guided.run(guided.done(count))
    assert not any(text.startswith("rejected") for number, text in guided.reported.items() if number > reported)
    assert any("tilted by 0.3 deg" in warning for warning in read_campaign(guided.folder).warnings)


def test_a_tilt_that_no_face_has_is_kept_only_with_a_yes(rig: Make) -> None:
    guided = on_debris(rig, 0.3)
    guided.execute("keep_seating")
    guided.run(lambda v: v.question is not None)
    guided.execute("answer", key="n")
    guided.rest(60)
    assert (guided.view.done, guided.view.question) == (3, None)
    guided.hands("place 4 8")
    guided.run(guided.done(4))
    assert guided.context.badly_seated == set()


def test_a_small_tilt_is_kept_without_a_question_and_holds_for_that_seat_alone(rig: Make) -> None:
    guided = on_debris(rig, 0.03)
    guided.execute("keep_seating")
    assert guided.view.question is None
    guided.hands("place 4 8 0 0.2 0")
    guided.run(lambda v: v.events[-1].sound == "rejected" and "tilted by 7" in v.events[-1].text)  # arcsec
    guided.hands("place 4 8 0 0.03 0")
    guided.run(guided.done(4))
    assert guided.context.badly_seated == {"dwell_04"}


@pytest.mark.parametrize(("tilt_deg", "marked"), [(0.03, set()), (0.3, {"dwell_03", "dwell_04"})])
def test_what_comes_back_the_same_is_the_bench_only_where_a_bench_may_be_so(
    rig: Make, tilt_deg: float, marked: set[str]
) -> None:
    guided = on_debris(rig, tilt_deg)
    guided.hands(f"place 4 8 0 {tilt_deg} 0")
    guided.run(guided.done(4))
    assert guided.context.badly_seated == marked
    doubt = kept_tilt_warning(read_campaign_toml(guided.folder)[0])
    assert ("record position 3 and position 4 again" in doubt) == bool(marked)
    assert (guided.view.step("dwell_03").state == "redo") == bool(marked)  # which of the two it was, nobody knows


def tilt(position: int, deg: float) -> str:
    """Return a tilt of the face that is up: about y where that is x, else about x."""
    return f"0 {deg} 0" if position <= 4 else f"{deg} 0 0"


def placed(guided: GuideRig, positions: tuple[int, ...], debris: dict[int, float]) -> None:
    """Place and accept positions, some of them on a crumb that tilts them by so much [deg]."""
    for position in positions:
        before = guided.view.step(f"dwell_{position:02d}").attempts
        guided.hands(f"place {position} 8 {tilt(position, debris.get(position, 0.0))}")
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
    guided.execute("redo", step=f"dwell_{position:02d}")
    placed(guided, (position,), {position: tilt_deg})


@pytest.mark.parametrize("is_resumed", [False, True])
def test_a_clean_seat_is_cleared_once_the_debris_before_it_is_wiped_off(rig: Make, is_resumed: bool) -> None:
    guided = guide(rig, 1, 2, 3, 4, 5, 6)
    placed(guided, (1, 2, 3, 4, 5), {5: 1.2})
    twice_off(guided, 6)
    assert "position 5 and position 6" in kept_tilt_warning(tables_of(guided))
    assert guided.view.wanted == "dwell_05"
    if is_resumed:
        guided.resume()
        guided.execute("redo", step="dwell_05")
    placed(guided, (5,), {})
    assert guided.context.badly_seated == set()
    assert "position 6 was seated correctly" in guided.texts[-1]
    assert not kept_tilt_warning(tables_of(guided))


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
    assert "position 3 and position 4" in kept_tilt_warning(tables_of(guided))
