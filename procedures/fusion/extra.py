"""The library of the extra ``locate``: asked for when it is needed, and named when it is not there."""

from importlib import import_module
from typing import Any

from procedures.errors import ProcedureError

COMMAND = "pip install 'fog-station[locate]'"


class ExtraMissing(ProcedureError, ImportError):
    """The library of the extra is not installed."""

    def __init__(self, package: str) -> None:
        self.package = package
        super().__init__(f"found no package {package}, expected the extra `locate`; install it with `{COMMAND}`")


def gtsam() -> Any:
    """Return the factor graph library.

    Raises
    ------
    ExtraMissing
        If it is not installed.
    """
    try:
        return import_module("gtsam")
    except ImportError:
        raise ExtraMissing("gtsam") from None
