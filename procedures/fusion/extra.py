"""The libraries of the extra ``locate``: asked for when they are needed, and named when they are not there."""

from importlib import import_module
from typing import Any

from procedures.errors import ProcedureError

COMMAND = "pip install 'fog-station[locate]'"


class ExtraMissing(ProcedureError, ImportError):
    """A library of the extra is not installed."""

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
    return _library("gtsam", "gtsam")


def opencv() -> Any:
    """Return the image library; raise `ExtraMissing` as `gtsam`."""
    return _library("cv2", "opencv-python-headless")


def _library(module: str, package: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise ExtraMissing(package) from None
