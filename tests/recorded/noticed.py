"""Choose calls by the mutants that they notice: what goes the same ways may give the same with a wrong number.

Each mutant of a module, those of `tests.mutation`, is tried in a fork, in which its function has its code: first
by the calls that are stored, then, if none gives something else, by those gathered that reach its statement.
"""

import ast
import gc
import json
import os
import pickle
import resource
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from tempfile import gettempdir
from types import FunctionType
from typing import Any, TypeVar

from tests.mutation.operators import Mutant, mutants
from tests.mutation.reach import function_at
from tests.mutation.trial import is_kernel
from tests.mutation.warm import functions_of, replaced
from tests.paths import ROOT
from tests.recorded.candidates import Candidate, Step, TooLong, limit, traced
from tests.recorded.held_values import HELD
from tests.recorded.parts import whole
from tests.recorded.replay import Call, Columns, differing, outcome, short

MOST_BYTES, MOST_S = 4 * 2**30, 300  # of memory and processor time, of a mutant's process
TRY_S, CALL_S = 0.8, 1.0  # processor time: for the calls gathered, of a mutant; of a call
ENOUGH = 4  # calls that notice a mutant: then others have their turn
STORED, UNFIT = -1, -2  # instead of the numbers of calls gathered
PER_MUTANT = 12_000  # characters that may be paid for a mutant that no stored call notices

T = TypeVar("T")


@dataclass(frozen=True)
class Weighed:
    """A call gathered, what it gives, and which mutants, by number, it notices that no stored call does."""

    candidate: Candidate
    arguments: Any
    gives: Mapping[str, Any]
    notices: set[int] = field(default_factory=set)


@dataclass(frozen=True)
class Noticed:
    """How many mutants of a module were tried, how many the stored calls notice, and the calls to add."""

    tried: int
    before: int
    after: int
    added: tuple[Candidate, ...]


def noticing(
    module: str, calls: Sequence[Call], gathered: Sequence[Candidate], texts: Mapping[str, str], has: set[str]
) -> Noticed:
    """Return the calls gathered that notice most of the mutants that ``calls``, with their arguments, do not.

    ``texts`` are the parts of the calls gathered, ``has`` the names of those that are stored already.
    """
    import_module(module.removesuffix(".py").replace("/", "."))
    path, source = ROOT / module, (ROOT / module).read_text(encoding="utf-8")
    kernels_are_python = bool(os.environ.get("NUMBA_DISABLE_JIT"))
    gc.unfreeze()  # what is frozen is not listed
    functions = {name: found for (file, name), found in functions_of(ROOT).items() if file == str(path)}
    gc.freeze()  # a fork would else copy what its collector touches
    weighed, stored = [*_weighed(gathered, texts)], [each for each in calls if each["call"] != HELD]
    ways = [_lines(module, each) for each in stored]
    reached = statements(source)
    tried = before = 0
    for number, mutant in enumerate(mutants(source, module)):
        name = function_at(source, mutant.line)
        if name not in functions or (is_kernel(mutant) and not kernels_are_python):
            continue
        lines = reached.get(mutant.line, {mutant.line})
        some = [each for each, way in zip(stored, ways, strict=True) if lines & way]
        near = [i for i, each in enumerate(weighed) if lines & lines_of(each.candidate.steps)]
        by = in_a_fork(lambda: _of_mutant(mutant, name, functions[name], module, some, weighed, near))  # noqa: B023
        tried, before = tried + (by != [UNFIT]), before + (by == [STORED])
        for i in by if by not in ([STORED], [UNFIT]) else ():
            weighed[i].notices.add(number)
    added = [*_fewest(weighed, texts, has)]
    after = before + len({number for each in added for number in each.notices})
    return Noticed(tried, before, after, tuple(each.candidate for each in added))


def lines_of(steps: Iterable[Step]) -> set[int]:
    """Return the lines among the steps that a call makes."""
    return {line for _, condition, line in steps if condition == -1}


def _lines(module: str, call: Call) -> set[int]:
    """Return the lines that a stored call reaches; all where tracing it takes too long."""
    limit(10 * CALL_S)  # it is traced
    try:
        return lines_of(traced(module, lambda: outcome(module, call["call"], call["with"]))[1])
    except (TooLong, Exception):
        return set(range(1, 10_000))
    finally:
        limit(0.0)


def _weighed(gathered: Sequence[Candidate], texts: Mapping[str, str]) -> Iterator[Weighed]:
    """Yield the calls gathered with what they give, the cheapest first."""
    for each in sorted(gathered, key=lambda one: one.cost + len(one.text)):
        arguments = whole(json.loads(each.text), texts)
        limit(CALL_S)
        try:
            yield Weighed(each, arguments, short(outcome(each.module, each.name, arguments)))
        except (TooLong, Exception):
            continue
        finally:
            limit(0.0)


def _of_mutant(
    mutant: Mutant, name: str, functions: Sequence[FunctionType], module: str, calls: Sequence[Call],
    weighed: Sequence[Weighed], near: Sequence[int],
) -> list[int]:  # fmt: skip
    """Return which calls gathered notice a mutant; `STORED` if one stored does, `UNFIT` if none can."""
    if not replaced(functions, ROOT / module, name, mutant.source):
        return [UNFIT]
    if any(_differs(module, each["call"], each["with"], each["gives"]) for each in calls):
        return [STORED]
    found, end = list[int](), time.process_time() + TRY_S
    for i in near:
        if len(found) == ENOUGH or time.process_time() > end:
            break
        if _differs(module, weighed[i].candidate.name, weighed[i].arguments, weighed[i].gives):
            found.append(i)
    return found


def _differs(module: str, name: str, arguments: Any, gives: Mapping[str, Any]) -> bool:
    limit(CALL_S)
    try:
        found: Columns = outcome(module, name, arguments, changes="changes" in gives)
        return any(differing(found, gives))
    except (TooLong, Exception):
        return True
    finally:
        limit(0.0)


def _fewest(weighed: Sequence[Weighed], texts: Mapping[str, str], has: set[str]) -> Iterator[Weighed]:
    """Yield the calls that notice most for the least text, until a mutant costs more than it may."""
    has, left = set(has), [each for each in weighed if each.notices]
    known = set[int]()

    def cost(each: Weighed) -> float:
        own = each.candidate
        return own.cost + len(own.text) + sum(len(texts[part]) for part in own.parts if part not in has)

    while left:
        best = max(left, key=lambda each: len(each.notices - known) / cost(each))
        if len(best.notices - known) * PER_MUTANT < cost(best):
            return
        yield best
        known |= best.notices
        has.update(best.candidate.parts)
        left = [each for each in left if each.notices - known]


def statements(source: str) -> dict[int, set[int]]:
    """Return of each line the lines of its statement, of one with a body those before it."""
    found: dict[int, set[int]] = {}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            end = max(node.lineno, body[0].lineno - 1) if body else node.end_lineno or node.lineno
            lines = set(range(node.lineno, end + 1))
            found |= {line: lines for line in lines if len(lines) < len(found.get(line, range(10**6)))}
    return found


def in_a_fork(call: Callable[[], list[T]]) -> list[T]:
    """Return what a call gives in a process of its own; none where that dies of it."""
    ours, theirs = os.pipe()
    if not (child := os.fork()):
        os.close(ours)
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, resource.RLIM_INFINITY))
        resource.setrlimit(resource.RLIMIT_CPU, (MOST_S, resource.RLIM_INFINITY))  # of a loop that heeds no signal
        os.chdir(gettempdir())
        with os.fdopen(theirs, "wb") as file:
            try:
                file.write(pickle.dumps(call()))
                file.flush()
            finally:
                os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as file:
        got = file.read()
    os.waitpid(child, 0)
    found: list[T] = pickle.loads(got) if got else []
    return found
