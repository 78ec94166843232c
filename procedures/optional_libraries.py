"""Libraries of extras: imported when they are needed, named with the command that installs them when missing."""

from importlib import import_module
from typing import Any

from procedures.errors import ErrorCode, ProcedureError


def install_command(extra: str) -> str:
    """Return what installs an extra, to be typed in the station's folder."""
    return f"make extra-{extra}"


class ExtraMissing(ProcedureError, ImportError):
    """A library that only an extra installs is missing."""

    code = ErrorCode.EXTRA_MISSING

    def __init__(self, package: str, extra: str, otherwise: str = "") -> None:
        self.package, self.extra = package, extra
        alternative = f", or {otherwise}" if otherwise else ""
        super().__init__(
            f"found no package {package}, expected the extra `{extra}`; install it with "
            f"`{install_command(extra)}` in the station's folder{alternative}"
        )


def opencv() -> Any:
    """Return the image library.

    Raises `ExtraMissing` if it is not installed.
    """
    try:
        return import_module("cv2")
    except ImportError:
        raise ExtraMissing("cv2", "camera") from None
