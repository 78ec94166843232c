"""What must not be, found in a campaign of the year."""


class Finding(AssertionError):
    """Something that must not be."""


def expect(holds: bool, otherwise: str) -> None:
    """Raise `Finding` with what is so ``otherwise``."""
    if not holds:
        raise Finding(otherwise)
