"""What the tests of whole areas ask for is computed once."""

from tests.computed_once import computed_once

__all__ = ["computed_once"]
