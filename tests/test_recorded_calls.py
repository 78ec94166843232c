"""Stored calls of each module give what they gave: `docs/station-tests.md` says how to store them anew."""

import gc
import json
import signal
from collections import OrderedDict
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.recorded.stored_modules import stored_modules


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # a file that a call leaves open
@pytest.mark.parametrize("module", stored_modules())
def test_stored_calls_give_what_is_stored(module: str) -> None:
    from tests.recorded.replay import different  # not as tests are collected: it loads numpy

    wrong = different(module)
    assert not wrong, f"{wrong}; if that is meant: python -m tests.recorded {module}"


@pytest.mark.parametrize(
    ("call", "arguments", "gives", "said"),
    [
        ("plural", {"count": 2, "noun": "gap"}, {".d.returns": ["2 gaps"]}, ""),
        ("plural", {"count": 3, "noun": "gap"}, {".d.returns": ["2 gaps"]}, "found ['3 gaps'], expected ['2"),
        ("plural", {"number": 2, "noun": "gap"}, {}, "it has no argument number"),
        ("plural", {"count": 2}, {}, "it needs noun, which is not stored"),
        ("many", {}, {}, "cannot be made now: AttributeError: many"),
    ],
)  # fmt: skip
def test_what_is_not_as_it_was_is_named(
    call: str, arguments: object, gives: object, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.recorded import replay

    monkeypatch.setattr(replay, "read", lambda _: [{"call": call, "with": {"d": arguments}, "gives": gives}])
    found = replay.different("station/text/plural.py")
    assert said in found
    assert bool(found) == bool(said)


def test_no_stored_call_names_a_place_of_one_machine() -> None:
    from tests.paths import MEMORY, ROOT

    files = [ROOT / "tests/recorded/parts.json", *(ROOT / "tests/recorded").rglob("*.json")]
    # a line of pyserial made again has the number of a descriptor, which it writes to and closes, whoever's it is
    for place in ("/tmp/", f"{MEMORY}/", "/home/", "/root/", f"{ROOT}/", "serial.serialposix:Serial"):
        assert [str(file) for file in files if place in file.read_text(encoding="utf-8")] == []


def test_values_come_back_from_text_as_they_were(tmp_path: Path) -> None:
    import numpy as np

    from procedures.attitude.complementary_gains import PAPER_GAINS, Gains
    from tests.recorded import folders
    from tests.recorded.stored_values import Decoder, Encoder

    (tmp_path / "log.csv").write_text("t\n1\n")
    folders.HERE[0] = tmp_path
    rng, turned = np.random.default_rng(3), np.arange(6.0).reshape(2, 3).T
    value = [
        1, 0.1, float("inf"), None, "text", (1, [2]), {3: {4}, "a": b"\xff" * 100}, slice(1, None),
        datetime(2026, 1, 2, tzinfo=UTC), np.float32(0.1), turned, np.array([True]), Gains(0.7, 0.03), PAPER_GAINS,
        np.zeros(2, [("a", "<u2"), ("b", "<f8", 3)]), tmp_path / "log.csv", rng,
    ]  # fmt: skip
    value.append(value[5])
    again = Decoder().of(json.loads(json.dumps(Encoder().of(value))))
    assert repr(again[:-2]) == repr(value[:-2])
    assert again[10].flags.f_contiguous
    assert again[13] is PAPER_GAINS
    assert again[-2].normal() == rng.normal()


def test_what_a_module_holds_beside_its_code_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """A number that stands in no function: of an effect, of a class, the default of an argument."""
    from dataclasses import replace

    from procedures.effects import clock_rate
    from tests.recorded import replay

    gives = replay.short(replay.outcome("procedures/effects/clock_rate.py", "", {"d": {}}))
    stored = [{"call": "", "with": {"d": {}}, "gives": gives}]
    monkeypatch.setattr(replay, "read", lambda _: stored)
    assert not replay.different("procedures/effects/clock_rate.py")
    monkeypatch.setattr(clock_rate, "EFFECT", replace(clock_rate.EFFECT, plausible=110.0))
    assert "found [110.0], expected [100.0]" in replay.different("procedures/effects/clock_rate.py")


def test_what_fills_as_it_is_used_is_not_held() -> None:
    from tests.recorded.held_values import held

    assert {"_UNTOLD", "_FAULTLESS"} & held("fixtures_db/declared_tables.py")["d"].keys() == {"_UNTOLD"}


def test_fields_and_arguments_have_their_defaults_among_what_a_module_holds() -> None:
    from tests.recorded.held_values import held

    assert held("procedures/counts/count_rate.py")["d"]["estimate_counts(starts)"] is None
    assert held("procedures/counts/count_rate.py")["d"]["_Path.is_thinned"] is False
    assert held("drivers/mavlink/fixes.py")["d"]["GPS_LEAP"] == 18
    assert (
        "metadata=["
        in held("station/files/fusion_folder/fusion_schema.py")["d"]["FusionImuTable.gyro_bias_std_rad_s"]
    )


@pytest.fixture
def own_limits(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Have as much time as a busy machine needs; afterwards the signals of limits are what they were."""
    from tests.recorded import noticed, varied

    for module, name in ((varied, "OF_FUNCTION_S"), (varied, "ONE_S"), (noticed, "TRY_S"), (noticed, "CALL_S")):
        monkeypatch.setattr(module, name, 60.0)
    handlers = {each: signal.getsignal(each) for each in (signal.SIGALRM, signal.SIGPROF)}
    guard = signal.getitimer(signal.ITIMER_REAL)
    yield
    for each, handler in handlers.items():
        signal.signal(each, handler)
    signal.setitimer(signal.ITIMER_REAL, *guard)
    gc.unfreeze()


@pytest.mark.usefixtures("own_limits")
def test_calls_are_chosen_by_the_mutants_that_they_notice() -> None:
    """Each of three notices both mutants of the only line: the cheapest is chosen, then none is left to notice."""
    from tests.recorded.candidates import Candidate
    from tests.recorded.noticed import noticing
    from tests.recorded.replay import outcome, short

    module = "station/text/plural.py"
    steps = frozenset((4, -1, line) for line in range(4, 8))
    texts = {count: json.dumps({"d": {"count": count, "noun": "gap"}}) for count in (2, 1, 30)}
    some = [Candidate(module, "plural", text, (), 60.0 + count, steps) for count, text in texts.items()]
    found = noticing(module, [], some, {}, set())
    assert (found.tried, found.before, found.after) == (2, 0, 2)
    assert [each.text for each in found.added] == [texts[1]]
    arguments = json.loads(texts[1])
    gives = short(outcome(module, "plural", arguments))
    again = noticing(module, [{"call": "plural", "with": arguments, "gives": gives}], some, {}, set())
    assert (again.before, again.after, again.added) == (2, 2, ())


def test_what_comes_again_is_the_same_thing_behind_slices_complex_numbers_and_keys() -> None:
    from procedures.campaign.plan_steps import Dwell
    from tests.recorded.stored_values import Decoder, Encoder

    part, key = [1.0], Dwell(1, 2.0)
    ordered = OrderedDict({key: part, Dwell(2, 3.0): part})
    stored = Encoder().of([slice(1, 2), 1j, part, {key: part, (1, key): [key]}, ordered, part, key])
    first, number, found, pairs, order, again, last = Decoder().of(json.loads(json.dumps(stored)))
    assert (first, number, found, last) == (slice(1, 2), 1j, part, key)
    assert found is again
    assert pairs[key] is found
    assert [*order] == [*ordered]
    assert all(each is found for each in order.values())
    assert next(iter(pairs)) is pairs[1, key][0] is last


def test_calls_are_varied_at_one_to_three_places_and_stay_calls() -> None:
    from random import Random

    import numpy as np

    from tests.recorded.stored_values import Decoder, Encoder
    from tests.recorded.varied import varied

    values = {
        "count": 2,
        "rate": 0.5,
        "is_on": True,
        "rows": np.arange(6.0).reshape(2, 3),
        "raw": b"\x01\x02",
        "of": [1],
    }
    tree, chance = Encoder().of(values), Random(1)
    seen: dict[str, set[str]] = {name: set() for name in values}
    for _ in range(300):
        again = Decoder().of(json.loads(json.dumps(varied(tree, [tree], chance))))
        assert again.keys() == values.keys()
        assert again["rows"].shape == (2, 3)
        assert sum(repr(value) != repr(values[name]) for name, value in again.items()) <= 3
        for name, value in again.items():
            seen[name].add(repr(value))
    assert {"1", "3", "0", "-2", "4"} <= seen["count"]
    assert seen["is_on"] == {"True", "False"}
    assert all(len(each) > 3 for name, each in seen.items() if name != "is_on")


def test_no_object_goes_where_others_are_counted_from_it() -> None:
    from random import Random

    from tests.recorded.stored_values import Decoder, Encoder
    from tests.recorded.varied import varied

    part = [1.0, 2.0]
    tree, chance = Encoder().of({"parts": [[3.0], part, part]}), Random(2)
    seen = set[str]()
    for _ in range(100):
        found = Decoder().of(json.loads(json.dumps(varied(tree, [tree], chance))))["parts"]
        assert len(found) == 3
        assert found[1] is found[2]
        seen.add(repr(found))
    assert len(seen) > 3


@pytest.mark.usefixtures("own_limits")
def test_a_varied_call_notices_what_no_call_of_the_tests_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three gaps do not show whether one or two are "1 gap": a call with another number does."""
    from tests.recorded.noticed import noticing
    from tests.recorded.replay import outcome, short
    from tests.recorded.varied import variants

    monkeypatch.delenv("PYTEST_DEBUG_TEMPROOT", raising=False)  # a call may write where temporary folders are
    module, arguments = "station/text/plural.py", {"d": {"count": 3, "noun": "gap"}}
    stored = [{"call": "plural", "with": arguments, "gives": short(outcome(module, "plural", arguments))}]
    before = noticing(module, stored, [], {}, set())
    found, texts = variants(module, [("plural", arguments)])
    after = noticing(module, stored, found, texts, set())
    assert before.after < after.after == after.tried
