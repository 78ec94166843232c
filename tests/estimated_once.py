"""Counts that many tests ask for are estimated once a process; a conftest takes the fixture in."""

import hashlib
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pytest

ESTIMATES = {
    "procedures.campaign.observations": "estimate_counts",
    "procedures.diagnosis.disturbed_blocks": "estimate_counts",
    "station.guide.accepted_dwell": "estimate_channels",
}


def remembering(estimate: Callable[..., list[object]]) -> Callable[..., list[object]]:
    """Return an estimate of counts, which depends on its arguments alone: the same ones are estimated once."""
    known: dict[bytes, tuple[object, ...]] = {}

    def estimated(*arguments: object) -> list[object]:
        key = hashlib.blake2b()
        _tell(key, arguments)
        name = key.digest()
        if name not in known:
            known[name] = tuple(estimate(*arguments))
        return list(known[name])

    return estimated


def _tell(key: "hashlib.blake2b", given: object) -> None:
    """Tell arguments, lists and arrays of any depth, apart from all others."""
    if isinstance(given, np.ndarray):
        array = np.ascontiguousarray(given)
        key.update(repr((array.dtype.str, array.shape)).encode())
        key.update(array.tobytes())
    elif isinstance(given, Sequence):
        key.update(f"[{len(given)}".encode())
        for each in given:
            _tell(key, each)
    else:
        key.update(repr(given).encode())


@pytest.fixture(scope="session", autouse=True)
def counts_are_estimated_once() -> Iterator[None]:
    """The estimates themselves have tests of their own, and these call them as they are."""
    from procedures.counts import count_rate

    once = {name: remembering(getattr(count_rate, name)) for name in ESTIMATES.values()}
    with pytest.MonkeyPatch.context() as patch:
        for module, name in ESTIMATES.items():
            patch.setattr(f"{module}.{name}", once[name])
        yield
