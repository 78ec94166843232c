"""What many tests ask for is computed once: rates of counts, diagnoses, drives. It is kept by a hash of the code.

The same question is asked by one test after another, by the other worker, and by the next run. An answer depends
on the question and on the code of the function's module and of all that it imports, directly or not. So it is kept
on the disk under a hash of both, of the libraries' versions and of the machine: where a line of that code differs,
nothing is known yet. What a question names besides, such as an effect of a test's own, is code that its answer
depends on, too. A test that puts something of its own in the place of a part of the program is answered by
the code as it then is; what it puts in the place of a method, of an item or of a part of a library is not seen. A
test that the same comes twice asks what is not kept: of a figure `draw_svg`. A path is a mere name: in a test's
folder, whose number changes, it is the same question in each run; an answer that names such a folder is not kept.

Functions of the program are named in `COMPUTED`, those of the tests have `known` before them.

``STATION_TESTS_COMPUTE=1`` computes everything anew.
"""

import copyreg
import hashlib
import io
import os
import pickle
import platform
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import fields
from functools import cache, partial, wraps
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from operator import attrgetter, is_
from pathlib import Path, PosixPath
from types import ModuleType
from typing import Any

import platformdirs
import pytest
from pydantic import BaseModel

from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from tests.code_behind import PACKAGES, digest, modules_behind, modules_named

# what is asked from outside; within a fit it matters that what comes back holds what was given, not equal copies
COMPUTED = (
    ("procedures.attitude.diagnosis.attitude_diagnosis", "diagnose_attitude"),
    ("procedures.bench.cube_measurement", "measure_cube"),
    ("procedures.calibration.joint_calibration", "fit"),
    ("procedures.calibration.joint_calibration", "solve"),
    ("procedures.counts.count_rate", "estimate_channels"),
    ("procedures.counts.count_rate", "estimate_counts"),
    ("procedures.counts.reference_time", "fit_clock"),
    ("procedures.diagnosis.channel_noise", "channel_noise"),
    ("procedures.diagnosis.declared_effects", "solve_declared"),
    ("procedures.diagnosis.diagnose", "diagnose"),
    ("procedures.diagnosis.disturbances", "find_disturbances"),
    ("procedures.diagnosis.left_directions", "worst_direction"),
    ("procedures.diagnosis.sample_effects", "sample_effects"),
    ("procedures.diagnosis.sample_turns", "periodic_in_turns"),
    ("procedures.diagnosis.single_channels", "single_channels"),
    ("procedures.discovery.discover", "discover"),
    ("procedures.earth.gyrocompass", "find_heading"),
    ("procedures.fusion.alignment.alignment_in_motion", "MovingAligner.align"),
    ("procedures.fusion.visual_alignment.camera_time", "camera_offset"),
    ("procedures.fusion.visual_alignment.visual_alignment_attempts", "align_by_camera"),
    ("procedures.history.unit_outliers", "judge_fleet"),
    ("procedures.planning.least_time", "least_time"),
    ("procedures.planning.least_time", "most_in_time"),
    ("procedures.tolerance.improvements", "remedy_gain"),
    ("procedures.tolerance.worst_case", "worst_corner"),
    ("station.locate.source_choice", "locate"),
    ("station.results.diagnosis.finding_figure", "residual_svg"),
    ("station.results.history.population_figure", "_svg"),
    ("station.results.history.unit_history", "analysis"),
    ("station.results.history.unit_history_figure", "history_svg"),
    ("station.results.noise.noise_plot", "noise_svg"),
    ("station.results.report.noise_figure", "allan_svg"),
    ("station.results.report.residual_plot", "residual_svg"),
    ("station.results.tolerance.tolerance_figure", "tolerance_svg"),
)
REMEMBERING = (
    ("procedures.planning.design_sigmas", "DesignSigmas"),
    ("procedures.planning.step_information", "StepInformation"),
)
BY_NAME = ("station.cli", "station.commands.fixtures", "station.sending.outputs", "station.tui.screens")
EFFECTS_MODULE = "procedures.effects"
AS_THEY_ARE = "tests.procedures.counts."  # the tests of what the counts say
OF_KEEPING = {"tests.code_behind", "tests.computed_once"}  # code behind each answer; `FORMAT` stands for it
FORMAT = "1"  # of what is kept; another one where answers are asked, written or read again otherwise
LIBRARIES = (  # whose version an answer depends on
    "cantools",
    "matplotlib",
    "mcap",
    "numba",
    "numpy",
    "opencv-python",
    "pydantic",
    "pymavlink",
    "scipy",
    "weasyprint",
)
WORTH_KEEPING_S = 0.004
OF_A_TEST = b"pytest-of-"  # in the path of each folder of a test, which has another number in each run
FOLDERS_OF_TESTS = re.compile(r"^/.*/pytest-of-[^/]+/pytest-\d+/(?:popen-gw\d+/)?")
PROGRAM = tuple(f"{each}." for each in PACKAGES if each != "tests")
STATES_KEPT = 3  # of the code of each function, the newest ones
Function = Callable[..., Any]


def kept(function: Function, folder: Path | None, have_changed: Callable[[Collection[str]], bool]) -> Function:
    """Return a function that knows what it returned before, in this process and in ``folder``.

    ``have_changed`` is asked of the modules that a question names beside those that the function depends on.
    """
    answers, behind = dict[bytes, bytes](), modules_behind(function.__module__)

    @wraps(function)
    def computed(*arguments: Any, **options: Any) -> Any:
        arrays = list[pickle.PickleBuffer]()  # megabytes, of which no name is looked for nor a copy made
        if (question := pickled((arguments, options), arrays.append)) is None:
            return function(*arguments, **options)
        besides = modules_named(question) - behind
        if have_changed(besides):
            return function(*arguments, **options)
        key = _hash_of([question, _code_of(frozenset(besides)), *(each.raw() for each in arrays)])
        file = None if folder is None else folder / f"{function.__name__}-{key.hex()}"
        if key in answers:
            return pickle.loads(answers[key])
        if file is not None and file.exists():
            return pickle.loads(file.read_bytes())
        begun = time.process_time()
        answer = function(*arguments, **options)
        if (found := pickled(answer)) is None or OF_A_TEST in found:
            return answer
        if file is not None and time.process_time() - begun > WORTH_KEEPING_S:
            _write(file, found)  # and not in memory as well: a worker grows to 1.4 GB
        else:
            answers[key] = found
        return pickle.loads(found)  # as who asks later gets it: what is asked with it then is the same question

    return computed


def _hash_of(parts: Iterable[bytes | memoryview]) -> bytes:
    found = hashlib.blake2b(digest_size=20)
    for each in parts:
        found.update(each)
    return found.digest()


@cache
def _code_of(modules: frozenset[str]) -> bytes:
    """Return a hash of the code of modules and of what they import; nothing where there are none."""
    return digest(set().union(*map(modules_behind, modules)) - OF_KEEPING) if modules else b""


def pickled(value: Any, apart: Callable[[pickle.PickleBuffer], Any] | None = None) -> bytes | None:
    """Return a value as bytes, None where it holds what cannot be written down.

    With ``apart`` it is a question: ``apart`` is handed what arrays hold and returns nothing, so that it stays
    out of the bytes; and paths are as seen from the folder of all tests.
    """
    written = io.BytesIO()
    kind = pickle.Pickler if apart is None else _Questions
    pickler = kind(written, pickle.HIGHEST_PROTOCOL, buffer_callback=apart)
    pickler.dispatch_table = {**copyreg.dispatch_table, Effect: _effect_written, **_remembering()}
    try:
        pickler.dump(value)
        return written.getvalue()
    except (pickle.PicklingError, AttributeError, TypeError):  # a function of a test's own
        return None


class _Questions(pickle.Pickler):
    """Writes what is the same in each run the same way; nothing is made of it again."""

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, PosixPath):
            return PosixPath, (FOLDERS_OF_TESTS.sub("folders of tests:", str(value)),)
        if isinstance(value, BaseModel):  # the names of its fields are a set, of another order in each process
            named = sorted(value.model_fields_set)
            return type(value), (value.__dict__, value.__pydantic_extra__, value.__pydantic_private__, named)
        return NotImplemented


def _effect_written(effect: Effect) -> str | tuple[Any, ...]:
    """Write an effect of the catalogue by its name: many hold functions that have none."""
    if any(effect is each for each in EFFECTS):
        return effect_of_catalogue, (EFFECTS_MODULE, effect.name)
    return effect.__reduce_ex__(pickle.HIGHEST_PROTOCOL)


@cache
def _remembering() -> dict[type, Callable[[Any], tuple[Any, ...]]]:
    """Return how classes that remember what they found are written; in words: few answers need their code."""
    return {getattr(import_module(module), name): _as_made for module, name in REMEMBERING}


def _as_made(value: Any) -> tuple[Any, ...]:
    """Write what it was made of, not what it has found since: with either it is the same question."""
    return type(value), tuple(getattr(value, each.name) for each in fields(value) if not each.name.startswith("_"))


def effect_of_catalogue(module: str, name: str) -> Effect:
    """Return an effect by the name of its module's catalogue, which a question so names, and by its own."""
    return next(each for each in import_module(module).EFFECTS if each.name == name)


def _write(file: Path, content: bytes) -> None:
    """Write whole or not at all: another worker may be reading."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as draft:
        draft.write(content)
    os.replace(draft.name, file)


def folder_of(module: str, name: str) -> Path | None:
    """Return where answers of a function's code are kept, None where none are wanted; drop those of older code.

    Raises
    ------
    TypeError
        If that code is not to be seen whole, because it imports one of `BY_NAME`.
    """
    if hidden := modules_behind(module) & {*BY_NAME}:
        raise TypeError(
            f"{module} imports {', '.join(hidden)}, which loads modules by names in a table: what {name} returned "
            "would still be known after a change of theirs; call what the command or the screen calls"
        )
    if os.environ.get("STATION_TESTS_COMPUTE"):
        return None
    libraries = [f"{each} {_version(each)}" for each in LIBRARIES]
    machine = "\n".join([FORMAT, *libraries, sys.version, *platform.uname()]).encode()
    state = _hash_of([digest(modules_behind(module) - OF_KEEPING), machine]).hex()
    states = platformdirs.user_cache_path("fog-station-test-answers") / f"{module}.{name}"
    folder = states / state
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder)
    for old in sorted(states.iterdir(), key=lambda state: state.stat().st_mtime)[:-STATES_KEPT]:
        shutil.rmtree(old, ignore_errors=True)
    return folder


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:  # of an extra
        return "none"


def known(function: Function) -> Function:
    """Return a function of the tests, of values that can be pickled, that knows what it returned before.

    Its answer may depend on code and on files directly in a package of the program, on no other files, so that a
    path that it is asked with is a mere name, and on nothing that a test puts in the place of a part of the tests.
    What it says and changes happens once.
    """

    @cache
    def begun() -> Function:
        behind = sorted(modules_behind(function.__module__))
        return kept(function, folder_of(function.__module__, function.__qualname__), partial(_changed, behind))

    @wraps(function)
    def asked(*arguments: Any, **options: Any) -> Any:
        return begun()(*arguments, **options)

    return asked


def _changed(behind: Collection[str], besides: Collection[str]) -> bool:
    return PARTS is None or PARTS.have_changed([*behind, *besides])


class Parts:
    """The functions, classes and numbers of the program, as each module was first seen.

    Every call of a function that knows what it returned asks, of the modules that it depends on alone: where
    nothing stands elsewhere in their dictionaries, that is seen without a look at names.
    """

    def __init__(self) -> None:
        self._seen = dict[str, dict[str, object]]()
        self._values = dict[str, tuple[object, ...]]()
        self.have_changed(list(sys.modules))

    def have_changed(self, modules: Iterable[str]) -> bool:
        """Say whether something else stands in the place of one of theirs."""
        there = [(name, sys.modules[name]) for name in modules if name in sys.modules]
        changed = [self._has_changed(*each) for each in there if each[0].startswith(PROGRAM)]
        return any(changed)  # every module is seen, also where one has

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


PARTS: Parts | None = None  # once the functions of `COMPUTED` are in their places


def look_anew() -> None:
    """Take the parts as they stand for their own; call it after a patch for all tests, else none is known."""
    global PARTS
    PARTS = None if PARTS is None else Parts()


@pytest.fixture(scope="session", autouse=True)
def computed_once() -> Iterator[None]:
    """The functions of `COMPUTED` are those that know what they returned before, wherever they are called."""
    global PARTS
    functions = dict[int, Function]()
    with pytest.MonkeyPatch.context() as patch:
        for module, name in COMPUTED:
            function = attrgetter(name)(import_module(module))
            asks = partial(_changed, sorted(modules_behind(module)))
            functions[id(function)] = kept(function, folder_of(module, name), asks)
            patch.setattr(f"{module}.{name}", functions[id(function)])
        for module, found in list(sys.modules.items()):
            for name, value in list(vars(found).items()) if not module.startswith(AS_THEY_ARE) else ():
                if id(value) in functions:
                    patch.setattr(found, name, functions[id(value)])
        PARTS = Parts()
        yield
        PARTS = None
