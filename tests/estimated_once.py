"""Counts that many tests ask for are estimated once a process; a conftest takes the fixture in."""

import hashlib
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pytest

MODULES = (
    "procedures.campaign.observations",
    "procedures.diagnosis.disturbed_blocks",
    "station.guide.accepted_dwell",
)


def remembering(estimate: Callable[..., list[object]]) -> Callable[..., list[object]]:
    """Return `estimate_counts`, which depends on its arguments alone: the same ones are estimated once."""
    known: dict[bytes, tuple[object, ...]] = {}

    def estimated(
        dwells: Sequence[np.ndarray],
        period: float,
        starts: Sequence[np.ndarray] | None = None,
        times: Sequence[np.ndarray] | None = None,
    ) -> list[object]:
        key = hashlib.blake2b(repr((len(dwells), period)).encode())
        for given in (dwells, starts, times):
            for each in (None,) if given is None else given:
                array = np.ascontiguousarray(each if each is not None else [])
                key.update(repr((each is None, array.dtype.str, array.shape)).encode())
                key.update(array.tobytes())
        name = key.digest()
        if name not in known:
            known[name] = tuple(estimate(dwells, period, starts, times))
        return list(known[name])

    return estimated


@pytest.fixture(scope="session", autouse=True)
def counts_are_estimated_once() -> Iterator[None]:
    """`estimate_counts` itself has tests of its own, and they call it as it is."""
    from procedures.counts.count_rate import estimate_counts

    once = remembering(estimate_counts)
    with pytest.MonkeyPatch.context() as patch:
        for module in MODULES:
            patch.setattr(f"{module}.estimate_counts", once)
        yield
