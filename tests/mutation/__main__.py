"""Plant small changes at random, one at a time, and see which no test notices: `python -m tests.mutation`.

``--seed S --count N [--jobs J] [--seconds T] [--paths ...] [--after ROW]``; `docs/mutation.md` explains it.
Exit code 1 if fewer than 92 % of the mutants are killed, those in ``equivalent.toml`` not counted.
"""

import argparse
import random
import sys
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue

from tests.mutation.neighbourhood import imports, near, ordered, recorded
from tests.mutation.operators import Mutant, mutants
from tests.mutation.reach import Reach, function_at
from tests.mutation.trial import Tree
from tests.paths import ROOT

MUTATED = (
    "procedures", "drivers", "fixtures_db", "station/stream", "station/files", "station/results",
    "station/calibrated", "station/attitude", "station/text",
)  # fmt: skip
MIN_KILLED = 0.92
WHOLE = 2  # files nearest to a function, its mirror first, that are run to their end however long it takes
OF_A_CONSTANT = 4  # files of tests near it, run whole
STORED = "tests/stored/test_"  # each goes through a whole area: near to whatever it calls
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
NUMBERS = "tests/test_numbers_pages.py"  # which reads every number that stands outside of functions


def drawn(root: Path, paths: Sequence[str], seed: int, count: int) -> list[Mutant]:
    """Return ``count`` mutants: of lines drawn at random, all alike, one each."""
    chance, lines = random.Random(seed), list[list[Mutant]]()
    for path in sorted(
        p for name in paths for p in ([root / name] if name.endswith(".py") else (root / name).rglob("*.py"))
    ):
        of_line: dict[int, list[Mutant]] = {}
        for each in mutants(path.read_text(encoding="utf-8"), str(path.relative_to(root))):
            of_line.setdefault(each.line, []).append(each)
        lines += [of_line[line] for line in sorted(of_line)]
    return [chance.choice(each) for each in chance.sample(lines, min(count, len(lines)))]


def reason(mutant: Mutant, known: Sequence[dict[str, str]]) -> str:
    """Return why a mutant cannot change a result, "" if that is not known."""
    what = {"file": mutant.file, "line": mutant.text, "before": mutant.before, "after": mutant.after}
    return next((each["reason"] for each in known if all(each[name] == what[name] for name in what)), "")


def tried(
    root: Path, work: Path, folders: tuple[str, ...], chosen: Sequence[Mutant], jobs: int, most_s: float
) -> Iterator[tuple[Mutant, str]]:
    """Yield each mutant with what killed it, "" for none; ``jobs`` at a time, each in a tree of its own."""
    packages = tuple(sorted({each.split("/")[0] for each in folders}))
    graph, reach, free = imports(root, (*packages, "tests")), Reach(work / "reach"), Queue[Tree]()
    held = [test for test in graph if test.startswith(STORED)]

    def laid(number: int) -> Tree:
        tree = Tree(root, work / f"tree{number}", packages, reach)
        tree.lay()
        free.put(tree)
        return tree

    def one(mutant: Mutant) -> tuple[Mutant, str]:
        tree, close = free.get(), near(mutant.file, graph)
        function = function_at((tree.at / mutant.file).read_text(encoding="utf-8"), mutant.line)
        pages = [] if function or not (tree.at / NUMBERS).is_file() else [NUMBERS]
        try:
            if killer := tree.by_calls(mutant, function, [*pages, *recorded(mutant.file, graph, tree.at)]):
                return mutant, killer
            killer, left = tree.nearby(mutant, function, close, most_s)
            if killer:
                return mutant, killer
            if not function:  # no test calls a constant: those near it, as they stand near
                return mutant, tree.outcome(mutant, function, close[:OF_A_CONSTANT], close)
            for test, text in reach.claimed(tree.at, [*left, *held]):
                reach.keep(test, text, tree.trace(test, is_whole=test in held))
            callers = reach.callers(mutant, function, graph)
            left += [test for test in held if test in callers and test not in left]
            likeliest = ordered(left, callers, reach.seconds, most_s)
            whole = [each for each in close[:WHOLE] if each not in likeliest and each in left]
            return mutant, tree.outcome(mutant, function, [*likeliest, *whole], close)
        finally:
            free.put(tree)

    with ThreadPoolExecutor(jobs) as pool:
        trees = list(pool.map(laid, range(jobs)))
        try:
            yield from pool.map(one, chosen)
        finally:
            for each in trees:
                each.end()


def row(number: int, mutant: Mutant, outcome: str) -> str:
    """Return a line of the table."""
    before, after = (" ".join(each.split())[:60] for each in (mutant.before, mutant.after))
    return f"| {number} | `{mutant.file}` {mutant.line} | {mutant.operator} | `{before}` | `{after}` | {outcome} |"


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw, try, print the table and the share."""
    parser = argparse.ArgumentParser(description="Plant small changes at random and see which no test notices.")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=20.0, help="of tests tried for each, the likeliest first")
    parser.add_argument("--paths", nargs="+", default=MUTATED)
    parser.add_argument("--after", type=int, default=0, help="the last row of a run that was ended: go on with it")
    asked = parser.parse_args(arguments)
    known = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["mutant"]
    chosen = drawn(ROOT, asked.paths, asked.seed, asked.count)
    same = [each for each in chosen if reason(each, known)]
    work = ROOT / "build/mutation"
    work.mkdir(parents=True, exist_ok=True)
    print("| | where | operator | before | after | killed by |\n|---|---|---|---|---|---|", flush=True)
    for number, each in enumerate(same):
        print(row(number + 1, each, f"equivalent: {reason(each, known)}"))
    rest, killed, first = [each for each in chosen if each not in same], 0, max(len(same), asked.after) + 1
    rest = rest[first - 1 - len(same) :]
    for number, (mutant, by) in enumerate(tried(ROOT, work, MUTATED, rest, asked.jobs, asked.seconds), first):
        killed += bool(by)
        print(row(number, mutant, by or "SURVIVED"), flush=True)
    print(f"\n{killed} of {len(rest)} killed, {100 * killed / max(len(rest), 1):.0f} %; {len(same)} equivalent")
    return int(killed < MIN_KILLED * len(rest))


if __name__ == "__main__":
    sys.exit(main())
