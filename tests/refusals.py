"""A refusal is asserted by its class, its stable code and the values that it carries, not by its English."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from procedures.errors import ErrorCode


@contextmanager
def refused(
    error: type[Exception], code: ErrorCode | None = None, *mentioned: str, **values: object
) -> Iterator[pytest.ExceptionInfo[Exception]]:
    """Assert that the block raises ``error`` with ``code`` and ``values`` of its attributes.

    ``mentioned`` are values that its line holds: a name, a number with its unit, an option. No sentence.
    """
    with pytest.raises(error) as caught:
        yield caught
    if code is not None:
        assert getattr(caught.value, "code", None) is code
    for name, value in values.items():
        assert getattr(caught.value, name) == value
    for each in mentioned:
        assert each in str(caught.value)
