"""Store calls of modules anew: ``python -m tests.recorded [MODULES]``; `docs/station-tests.md` explains it."""

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence

from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

from tests.paths import ROOT
from tests.recorded import storing
from tests.recorded.stored_modules import stored_modules
from tests.recorded.watched import KEPT

NARROW = " ".join(each for each in __cpu_dispatch__ if __cpu_features__.get(each))  # numpy's sums without them
OTHERWISE = (  # another order, time, rounding
    {
        "PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "OPENBLAS_CORETYPE": "Nehalem", "RECORDED_CLOCK": "5",
        "NPY_DISABLE_CPU_FEATURES": NARROW,
    },
    {"PYTHONHASHSEED": "8", "OPENBLAS_CORETYPE": "SkylakeX", "RECORDED_CLOCK": "1e9"},
    {"PYTHONHASHSEED": "9", "OPENBLAS_CORETYPE": "Haswell", "RECORDED_CLOCK": "4e9"},
)  # fmt: skip
NEEDS = {"SkylakeX": "AVX512F", "Haswell": "AVX2"}  # a processor without dies of such a kernel


def known(asked: Sequence[str], among: Sequence[str]) -> list[str]:
    """Return the modules of these files and folders, all without any."""
    return [each for each in among if not asked or each.startswith(tuple(asked))]


def hold(modules: Sequence[str]) -> None:
    """Store what the calls give, without what other processes give otherwise."""
    for environment in map(dict, OTHERWISE):
        if not __cpu_features__.get(NEEDS.get(environment["OPENBLAS_CORETYPE"], "SSE2")):
            del environment["OPENBLAS_CORETYPE"]
        asked = [sys.executable, "-m", "tests.recorded", "--note", *modules]
        subprocess.run(asked, env=os.environ | environment, check=True)
        for each in known(modules, stored_modules()):
            storing.leave_out(each)
    storing.tidy()


def watch(tests: Sequence[str], modules: Sequence[str]) -> None:
    """Run tests and keep calls of modules."""
    for each in modules:
        shutil.rmtree(KEPT / each, ignore_errors=True)
    plain = ["-n", "0", "-q", "-p", "no:cacheprovider", "-p", "tests.recorded.watched"]
    environment = os.environ | {"WATCHED": " ".join(modules), "STATION_TESTS_COMPUTE": "1"}
    subprocess.run([sys.executable, "-m", "pytest", *plain, *tests], env=environment, check=False)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the stored calls of modules again, or choose others among those that tests make."""
    parser = argparse.ArgumentParser(description="Store what the calls of modules give, anew.")
    parser.add_argument("modules", nargs="*", help="files or folders; without any all")
    parser.add_argument(
        "--watch", nargs="+", metavar="TESTS", help="choose calls anew, among those of these tests"
    )
    parser.add_argument("--gather", action="store_true", help="of the calls kept, find those that can be stored")
    parser.add_argument("--choose", action="store_true", help="of those found, store the ones that reach most")
    parser.add_argument("--more", action="store_true", help="what is stored stays; choose what it does not reach")
    parser.add_argument(
        "--noticing", type=int, metavar="JOBS", help="add of those found the ones that notice more mutants"
    )
    parser.add_argument("--varied", action="store_true", help="with --noticing: also of calls changed a little")
    parser.add_argument("--values", action="store_true", help="store what modules hold beside their code")
    parser.add_argument("--note", action="store_true", help="what is given in this process")
    asked = parser.parse_args(arguments)
    if asked.noticing and (asked.watch or asked.choose):
        parser.error("--noticing chooses among what was found before: leave out --watch and --choose")
    if asked.varied and not asked.noticing:
        parser.error("--varied is for --noticing: give both")
    if asked.watch:
        watch(asked.watch, asked.modules)
    kept = sorted(
        str(each.relative_to(KEPT)) for each in KEPT.rglob("*.py") if (ROOT / each.relative_to(KEPT)).is_file()
    )
    if asked.watch or asked.gather:
        for each in known(asked.modules, kept):
            storing.gather(each)
    if asked.watch or asked.choose:
        storing.choose(known(asked.modules, kept), more=asked.more)
        storing.hold_values(known(asked.modules, kept))
    elif asked.values:
        storing.hold_values(asked.modules)
    elif asked.noticing:
        among = sorted({*kept, *stored_modules()}) if asked.varied else kept
        storing.choose_noticing(known(asked.modules, among), asked.noticing, vary=asked.varied)
    elif not asked.gather and not asked.note:
        for each in known(asked.modules, stored_modules()):
            storing.renew(each)
    if asked.note:
        storing.set_clocks()  # before modules take `monotonic` from `time`
        for each in reversed(known(asked.modules, stored_modules())):
            storing.note(each)
    elif not asked.gather:
        hold(asked.modules)
    return 0


if __name__ == "__main__":
    sys.exit(main())
