"""Which file of tests a worker runs next."""

from pathlib import Path

from tests.waits_beside_work import COMPUTING, LONGEST, WAITING, following, waits

ROOT = Path(__file__).parents[1]


def test_the_longest_are_there_and_wait() -> None:
    assert all(waits(each, ROOT) for each in LONGEST)


def test_what_computes_though_it_names_a_device_is_there_and_names_one() -> None:
    for each in COMPUTING:
        assert any(word in (ROOT / each).read_text() for word in WAITING), each
        assert not waits(each, ROOT)


def test_one_worker_of_three_waits_and_the_others_compute_from_both_ends(tmp_path: Path) -> None:
    files = {
        "a.py": "",
        "b.py": "from tests.patience import paced",
        "c.py": "",
        "d.py": "SimulatedDevice()",
        "e.py": "",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert [following(list(files), worker, tmp_path) for worker in range(6)] == [
        "b.py", "a.py", "e.py", "b.py", "a.py", "e.py",
    ]  # fmt: skip
    assert following(["a.py", "c.py"], 0, tmp_path) == "a.py"
    assert following(["b.py", "d.py"], 1, tmp_path) == "b.py"


def test_the_longest_begins() -> None:
    some = ["tests/station/tui/test_whole_campaign.py", LONGEST[1], LONGEST[0]]
    assert following(some, 0, ROOT) == LONGEST[0]
