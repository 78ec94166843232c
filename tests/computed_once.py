"""What many tests ask for is computed once: the rates of counts, diagnoses. It is kept by a hash of the code.

The same question is asked by one test after another, by the other worker, and by the next run. An answer depends
on the question and on the code in `procedures/` alone, so it is kept on the disk under a hash of both, of the
libraries' versions and of the machine: where a line of that code differs, nothing is known yet. A test that puts
something of its own in the place of a part of `procedures` is answered by the code as it then is.

``STATION_TESTS_COMPUTE=1`` computes everything anew.
"""

import hashlib
import os
import pickle
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator
from functools import wraps
from importlib import import_module
from importlib.metadata import version
from operator import is_
from pathlib import Path
from types import ModuleType
from typing import Any

import platformdirs
import pytest

from tests.paths import ROOT

COMPUTED = (
    ("procedures.counts.count_rate", "estimate_counts"),
    ("procedures.counts.count_rate", "estimate_channels"),
    ("procedures.diagnosis.diagnose", "diagnose"),
)
AS_THEY_ARE = "tests.procedures.counts."  # the tests of what the counts say
WORTH_KEEPING_S = 0.05
STATES_KEPT = 3  # of the code, the newest ones
Function = Callable[..., Any]


def kept(function: Function, folder: Path | None, have_changed: Callable[[], bool]) -> Function:
    """Return a function that knows what it returned before, in this process and in ``folder``."""
    known = dict[bytes, bytes]()

    @wraps(function)
    def computed(*arguments: Any, **options: Any) -> Any:
        if have_changed() or (question := _pickled((arguments, options))) is None:
            return function(*arguments, **options)
        key = hashlib.blake2b(question, digest_size=20).digest()
        file = None if folder is None else folder / f"{function.__name__}-{key.hex()}"
        if key not in known and file is not None and file.exists():
            known[key] = file.read_bytes()
        if key in known:
            return pickle.loads(known[key])
        begun = time.process_time()
        answer = function(*arguments, **options)
        if (found := _pickled(answer)) is not None:
            known[key] = found
            if file is not None and time.process_time() - begun > WORTH_KEEPING_S:
                _write(file, found)
        return answer

    return computed


def _pickled(value: Any) -> bytes | None:
    try:
        return pickle.dumps(value, pickle.HIGHEST_PROTOCOL)
    except (pickle.PicklingError, AttributeError, TypeError):  # a function of a test's own
        return None


def _write(file: Path, content: bytes) -> None:
    """Write whole or not at all: another worker may be reading."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as draft:
        draft.write(content)
    os.replace(draft.name, file)


def folder_of_this_code() -> Path | None:
    """Return where this code's answers are kept, None where none are wanted; drop those of older code."""
    if os.environ.get("STATION_TESTS_COMPUTE"):
        return None
    found = hashlib.blake2b(digest_size=20)
    for path in sorted((ROOT / "procedures").rglob("*.py")):
        found.update(f"{path.relative_to(ROOT)}\n".encode() + path.read_bytes())
    libraries = [f"{name} {version(name)}" for name in ("numpy", "scipy", "numba")]
    found.update("\n".join([*libraries, sys.version, *platform.uname()]).encode())
    states = platformdirs.user_cache_path("fog-station-tests")
    folder = states / found.hexdigest()
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder)
    for old in sorted(states.iterdir(), key=lambda state: state.stat().st_mtime)[:-STATES_KEPT]:
        shutil.rmtree(old, ignore_errors=True)
    return folder


class Parts:
    """The functions, classes and numbers of `procedures`, as each module was first seen.

    Every call of a function that knows what it returned asks: where nothing stands elsewhere in the modules'
    dictionaries, that is seen without a look at names.
    """

    def __init__(self) -> None:
        self._modules, self._every = list[tuple[str, ModuleType]](), tuple[ModuleType, ...]()
        self._seen = dict[str, dict[str, object]]()
        self._values = dict[str, tuple[object, ...]]()
        self.have_changed()

    def have_changed(self) -> bool:
        """Say whether something else stands in the place of one of them."""
        if not _are(sys.modules.values(), self._every):
            self._every = tuple(sys.modules.values())
            self._modules = [each for each in list(sys.modules.items()) if each[0].startswith("procedures.")]
        changed = [self._has_changed(*each) for each in self._modules]  # every module is seen, also where one has
        return any(changed)

    def _has_changed(self, name: str, module: ModuleType) -> bool:
        if _are(vars(module).values(), self._values.get(name, ())):
            return False
        now = {part: value for part, value in vars(module).items() if not part.startswith("__")}
        seen = self._seen.setdefault(name, now)
        if any(now.get(part) is not value for part, value in seen.items()):
            return True
        self._values[name] = tuple(vars(module).values())
        return False


def _are(values: Collection[object], known: tuple[object, ...]) -> bool:
    return len(values) == len(known) and all(map(is_, values, known))


@pytest.fixture(scope="session", autouse=True)
def computed_once() -> Iterator[None]:
    """The functions of `COMPUTED` are those that know what they returned before, wherever they are called."""
    folder, functions = folder_of_this_code(), dict[int, Function]()
    with pytest.MonkeyPatch.context() as patch:
        parts: Parts | None = None
        for module, name in COMPUTED:
            function = getattr(import_module(module), name)
            functions[id(function)] = kept(function, folder, lambda: parts is None or parts.have_changed())
        for module, found in list(sys.modules.items()):
            for name, value in list(vars(found).items()) if not module.startswith(AS_THEY_ARE) else ():
                if id(value) in functions:
                    patch.setattr(found, name, functions[id(value)])
        parts = Parts()
        yield
