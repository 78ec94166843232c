"""The library of the extra ``camera``: asked for when needed, named when not there."""

from importlib import import_module
from typing import Any

from procedures.errors import ProcedureError


class ExtraMissing(ProcedureError, ImportError):
    """The library of the extra is not installed."""

    def __init__(self, package: str, extra: str) -> None:
        self.package, self.extra = package, extra
        command = f"pip install 'fog-station[{extra}]'"
        super().__init__(f"found no package {package}, expected the extra `{extra}`; install it with `{command}`")


def opencv() -> Any:
    """Return the image library.

    Raises
    ------
    ExtraMissing
        If it is not installed.
    """
    try:
        return import_module("cv2")
    except ImportError:
        raise ExtraMissing("cv2", "camera") from None
