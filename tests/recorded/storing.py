"""Gather, choose and store calls of modules; make stored ones again; leave out what is not always the same."""

import json
import os
import pickle
import re
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

import time_machine

from tests.paths import DATA, MEMORY, ROOT
from tests.recorded import candidates
from tests.recorded.candidates import Candidate, Step, traced
from tests.recorded.choice import chosen, shared_sizes
from tests.recorded.held_values import HELD, held
from tests.recorded.noticed import Noticed, noticing
from tests.recorded.parts import parted, parts, text_of, whole, write_parts
from tests.recorded.replay import Call, Columns, differing, outcome, read, short, stored, write
from tests.recorded.stored_modules import stored_modules
from tests.recorded.varied import variants
from tests.stored.held import differences

GATHERED, NOTED = ROOT / "build/recorded/candidates", ROOT / "build/recorded/noted"
PLACES = tuple(f"{place}/" for place in (tempfile.gettempdir(), MEMORY, ROOT, DATA, Path.home()))  # of one machine
MIGRATIONS = "fixtures_db/migrations/"  # run as they are imported, by alembic
PART = r'\{"#":"(\w+)"\}'  # a part where it is referred to
LEFT_OUT = 0.3  # of a result: beyond it the call is left out


def gather(module: str) -> None:
    """Find those of the calls kept of a module that may be stored."""
    candidates.REFUSED.clear()
    found, texts = list[Candidate](), dict[str, str]()
    for each in candidates.of_module(module):
        if names_a_place(each.text):
            continue
        own: dict[str, str] = {}
        tree = {"d": {key: parted(value, own) for key, value in json.loads(each.text)["d"].items()}}
        texts |= own
        found.append(replace(each, text=text_of(tree), parts=tuple(own)))
    file = GATHERED / f"{module}.pickle"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(pickle.dumps((found, texts)))
    refused = Counter(each.rpartition(": ")[2][:60] for each in candidates.REFUSED)
    print(module, len(found), *[f"{n} x {why}" for why, n in refused.most_common(3)], sep="; ", flush=True)


def names_a_place(text: str) -> bool:
    """Say whether a text names a file, a folder or an open descriptor that another machine does not have."""
    return any(place in text for place in PLACES) or "serial.serialposix:Serial" in text


def choose(modules: Sequence[str], *, more: bool = False) -> None:
    """Choose among all that were gathered of modules; what they give is stored by `leave_out`.

    With ``more`` what is stored stays, and calls are added that reach what it does not.
    """
    gathered = dict[str, list[Candidate]]()
    texts: dict[str, str] = {}
    for file in sorted(GATHERED.rglob("*.pickle")):
        found, own = pickle.loads(file.read_bytes())
        gathered[str(file.relative_to(GATHERED)).removesuffix(".pickle")] = found
        texts |= own
    sizes = shared_sizes([each for found in gathered.values() for each in found], texts)
    of_these = () if more else modules
    has = set(parts()) - {part for each in of_these if stored(each).exists() for part in parts_of(each)}
    texts |= parts()
    for module in modules:
        stay = [each for each in stored_calls(module) if more or each["call"] == HELD]
        some = chosen(
            gathered.get(module, []), sizes, has, [step for each in stay for step in steps_of(module, each)]
        )
        new: list[Call] = [{"call": each.name, "with": json.loads(each.text), "gives": {}} for each in some]
        if stay or new:
            write(module, sorted(stay + new, key=lambda each: str(each["call"])))
    write_parts(texts)


def stored_calls(module: str) -> list[Call]:
    """Return the calls stored of a module as they are stored; none of a module that has no file."""
    calls: list[Call] = json.loads(stored(module).read_text(encoding="utf-8")) if stored(module).exists() else []
    return calls


def hold_values(asked: Sequence[str]) -> None:
    """Store, of files and those in folders that do not have it yet, what each module holds beside its code."""
    paths = [
        path for each in asked for path in ([ROOT / each] if each.endswith(".py") else (ROOT / each).rglob("*.py"))
    ]
    for module in sorted(str(path.relative_to(ROOT)) for path in paths):
        if module.startswith(MIGRATIONS):
            continue
        calls = stored_calls(module)
        if HELD not in [each["call"] for each in calls] and held(module)["d"]:
            write(module, [{"call": HELD, "with": {"d": {}}, "gives": {}}, *calls])


def choose_noticing(modules: Sequence[str], jobs: int, *, vary: bool = False) -> None:
    """Add to the stored calls of modules those gathered that notice mutants which no stored call does.

    With ``vary`` also calls that differ a little from those stored and gathered.
    """
    of_all, wanted = parts(), dict[str, str]()
    with get_context("spawn").Pool(jobs, maxtasksperchild=8) as pool:  # what one imports, the next one forks
        for module, (found, texts) in zip(
            modules, pool.imap(partial(noticing_in, vary=vary), modules), strict=True
        ):
            calls = stored_calls(module)
            new: list[Call] = [{"call": e.name, "with": json.loads(e.text), "gives": {}} for e in found.added]
            write(module, sorted(calls + new, key=lambda each: str(each["call"])))
            wanted |= texts
            write_parts(of_all | wanted)
            print(f"{module}: of {found.tried} mutants {found.before}, then {found.after}", flush=True)


def noticing_in(module: str, *, vary: bool = False) -> tuple[Noticed, dict[str, str]]:
    """Return which calls gathered of a module, or varied, are to be added, and the parts of these."""
    file = GATHERED / f"{module}.pickle"
    gathered, texts = pickle.loads(file.read_bytes()) if file.exists() else ([], {})
    of_all, calls = texts | parts(), read(module) if stored(module).exists() else []
    if vary:
        of_found = [(each.name, whole(json.loads(each.text), of_all)) for each in gathered]
        more, own = variants(module, [(each["call"], each["with"]) for each in calls] + of_found)
        gathered, of_all = gathered + more, own | of_all
    found = noticing(module, calls, gathered, of_all, set(parts()))
    wanted = with_those_within({part for each in found.added for part in each.parts}, of_all)
    return found, {part: of_all[part] for part in wanted}


def steps_of(module: str, call: Call) -> frozenset[Step]:
    """Return the steps that a stored call makes."""
    import_module(module.removesuffix(".py").replace("/", "."))
    return traced(module, lambda: outcome(module, call["call"], whole(call["with"], parts())))[1]


def parts_of(module: str) -> set[str]:
    """Return the parts that stored calls refer to, without those within parts."""
    return set(re.findall(PART, stored(module).read_text(encoding="utf-8")))


def tidy() -> None:
    """Forget the calls that name places of this machine, then the parts that no call refers to."""
    of: Mapping[str, str] = parts()
    for module in stored_modules():
        calls = json.loads(stored(module).read_text(encoding="utf-8"))
        kept = [each for each in calls if not names_a_place(text_of(each | {"with": whole(each["with"], of)}))]
        if len(kept) < len(calls):
            print(f"{module}: {len(calls) - len(kept)} calls name what this machine alone has and are left out")
            write(module, kept)
    found = with_those_within({part for module in stored_modules() for part in parts_of(module)}, of)
    write_parts({name: of[name] for name in found})


def with_those_within(names: set[str], of: Mapping[str, str]) -> set[str]:
    """Return the names of parts and of those that they refer to; ``of`` has their texts."""
    waiting, found = names, set[str]()
    while waiting:
        found |= waiting
        waiting = {part for each in waiting for part in re.findall(PART, of[each])} - found
    return found


def renew(module: str) -> None:
    """Store what the stored calls of a module give now; say which can no longer be made, and leave those out."""
    calls = list[Call]()
    for each in json.loads(stored(module).read_text(encoding="utf-8")):
        try:
            gives = outcome(module, each["call"], whole(each["with"], parts()))
            calls.append(each | {"gives": short(gives)})
            if moved := list(differing(gives, each["gives"])):
                print(f"{module}: {each['call']}: {len(moved)} of {len(gives)} differ, {moved[0]}")
        except Exception as error:
            print(f"{module}: {each['call']} cannot be made now and is left out: {type(error).__name__}: {error}")
    write(module, calls)


def set_clocks() -> None:
    """Let `datetime`, ``time.time`` and ``time.monotonic`` begin at ``RECORDED_CLOCK`` [s]; not files' times."""
    if begin := os.environ.get("RECORDED_CLOCK"):
        time_machine.travel(float(begin)).start()  # how old a document is, is no result
        plain, first = time.monotonic, time.monotonic()
        time.monotonic = lambda: plain() - first + float(begin)
        time.monotonic_ns = lambda: round(1e9 * time.monotonic())


def note(module: str) -> None:
    """Keep in a file of its own all that the stored calls of a module give in this process."""
    found = list[Columns]()
    for each in reversed(read(module)):  # what one call leaves behind for the next is no result
        try:
            found.insert(0, outcome(module, each["call"], each["with"]))
        except Exception:
            found.insert(0, {})
    file = NOTED / f"{module}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text_of(found), encoding="utf-8")


def leave_out(module: str) -> None:
    """Leave out of what is stored what differs in a process that rounds, sorts and dates otherwise."""
    calls, noted = list[Call](), json.loads((NOTED / f"{module}.json").read_text(encoding="utf-8"))
    for each, there in zip(json.loads(stored(module).read_text(encoding="utf-8")), noted, strict=True):
        try:
            here = outcome(module, each["call"], whole(each["with"], parts()))
        except Exception as error:
            print(f"{module}: {each['call']} is left out: {error}")
            continue
        before = set(each["gives"].get("without", ()))
        without = [path for path in here if path in before or list(differences(there, {path: here[path]}))]
        if len(without) > LEFT_OUT * len(here) or (here.keys() ^ there.keys()) - set(without):
            print(f"{module}: {each['call']} is left out: {len(without)} of {len(here)} differ")
            continue
        calls.append(each | {"gives": short(here, without)})
        if without:
            print(f"{module}: {each['call']}: {len(without)} of {len(here)} not held: {without[0]}")
    write(module, calls)
