"""Choose among calls those few that reach most lines for the least text."""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence

from tests.recorded.candidates import Candidate, Step

AGAIN = (1.0, 0.5, 0.3, 0.2, 0.15, 0.1)  # what it is worth to reach a line once, twice ...
PER_STEP = 250  # characters that may be paid for a step from line to line


def is_public(name: str) -> bool:
    return not any(each.startswith("_") and not each.endswith("__") for each in name.split("."))


def chosen(
    candidates: Sequence[Candidate], sizes: Mapping[str, int], has: set[str], known: Sequence[Step] = ()
) -> list[Candidate]:
    """Return the calls of a module chosen: public functions' first, helpers' for what these leave.

    ``sizes`` is what a part costs: its length by the number of functions that are handed it; ``has`` are parts
    that others have paid for; ``known`` are steps that calls make which are stored already, each as often.
    """
    reached, found = Counter[Step](known), list[Candidate]()

    def worth(each: Candidate) -> float:
        return sum(AGAIN[reached[step]] for step in each.steps if reached[step] < len(AGAIN))

    def cost(each: Candidate) -> float:
        return each.cost + len(each.text) + sum(sizes[part] for part in each.parts if part not in has)

    for group in ([each for each in candidates if is_public(each.name)], candidates):
        left = [each for each in group if each not in found]
        while left:
            best = max(left, key=lambda each: worth(each) / cost(each))
            if worth(best) * PER_STEP < cost(best):
                break
            found.append(best)
            reached.update(best.steps)
            has.update(best.parts)
            left.remove(best)
    return sorted(found, key=lambda each: each.name)


def shared_sizes(candidates: Sequence[Candidate], texts: Mapping[str, str]) -> dict[str, int]:
    """Return what each part costs: its length by the number of functions that are handed it."""
    functions = defaultdict[str, set[tuple[str, str]]](set)
    for each in candidates:
        for part in each.parts:
            functions[part].add((each.module, each.name))
    return {part: len(texts[part]) // len(of) for part, of in functions.items()}
