"""One hash of all code that a result may depend on, so that other code is seen even where no version says so.

It covers every source file of the four packages, the module of the function that is run, and the versions of the
libraries that compute. A version alone would not do: two states of a checkout with changes share one.
"""

import hashlib
import importlib.util
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

PACKAGES = ("procedures", "drivers", "fixtures_db", "station")
LIBRARIES = ("numpy", "scipy", "numba")


@cache
def code_hash(module: str) -> str:
    """Return the SHA-256 [hex] of the code that a function of ``module`` may run."""
    total = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
    for library in LIBRARIES:
        total.update(f"\n{library} {version(library)}".encode())
    root = Path(__file__).resolve().parents[3]
    files = [(str(path.relative_to(root)), path) for name in PACKAGES for path in (root / name).rglob("*.py")]
    for name, path in [*sorted(files), (module, _source(module))]:
        total.update(f"\n{name} {hashlib.sha256(path.read_bytes()).hexdigest()}".encode())
    return total.hexdigest()


def _source(module: str) -> Path:
    spec = importlib.util.find_spec(module)
    if module == "__main__" or spec is None or spec.origin is None:
        raise ValueError(f"module {module!r} has no file: expected a function of one that workers can import")
    return Path(spec.origin)
