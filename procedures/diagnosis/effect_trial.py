"""A trial of an effect: whatever goes wrong in it says that the effect does not fit, and nothing of the data.

The data were held to their labels, and the model without effects was fitted to them, before any effect was tried.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from procedures.errors import DoesNotFit, ProcedureError


@contextmanager
def trial() -> Iterator[None]:
    """Turn what a refit or a test with an effect in it runs into to `DoesNotFit`."""
    try:
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            yield
    except DoesNotFit:
        raise
    except (ProcedureError, np.linalg.LinAlgError, FloatingPointError) as error:
        raise DoesNotFit(f"the model with the effect in it cannot be fitted: {error}") from error
