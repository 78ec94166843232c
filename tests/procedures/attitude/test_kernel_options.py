"""numba's own cache looks at the file of a kernel alone, not at those of the kernels that it calls."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import procedures
from procedures.attitude.kalman_kernels import filter_log
from procedures.attitude.kernel_options import sources

RUN = """
import numpy as np
from procedures.attitude.complementary_kernels import MIXER, MixingLaw
from procedures.attitude.complementary_velocity_aids import mix_speed
mixers = np.zeros(1, MIXER)
mixers[0].down[2] = 1.0
force, velocity = np.array([1e-3, 0.0, 0.0]), np.array([9.0, 0.0, 0.0])
mix_speed(mixers, MixingLaw(0.1, 0.1, 1.0), 0.1, np.zeros(3), force, velocity)
print(len(mix_speed.stats.cache_hits), mixers[0].down[0] != 0.0)
"""


def test_a_changed_kernel_makes_its_callers_compile_again(tmp_path: Path) -> None:
    here = Path(procedures.__file__).parent
    shutil.copytree(here, tmp_path / "procedures", ignore=shutil.ignore_patterns("__pycache__"))
    assert _run(tmp_path) == "0 True"
    assert _run(tmp_path) == "1 True"
    callee = tmp_path / "procedures" / "attitude" / "complementary_kernels.py"
    text = callee.read_text()
    assert "MIN_FORCE_NORM = 1e-9" in text
    callee.write_text(text.replace("MIN_FORCE_NORM = 1e-9", "MIN_FORCE_NORM = 1e-1"))  # of |f|, which is less here
    assert _run(tmp_path) == "0 False"


def test_a_kernel_knows_all_that_is_compiled_into_it() -> None:
    found = {name.removeprefix("procedures.attitude.") for name in sources(filter_log.__wrapped__)}
    assert {
        "kalman_kernels.filter_log",
        "kalman_update.measure",
        "kalman_measurements.REST_NORM_TOLERANCE",
    } <= found


def _run(folder: Path) -> str:
    """Return what a process of its own prints: compiled code from the cache, whether the gravity vector moved."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA")}
    done = subprocess.run(
        [sys.executable, "-c", RUN], cwd=folder, env=environment | {"PYTHONPATH": str(folder)}, check=True,
        capture_output=True, text=True,
    )  # fmt: skip
    return done.stdout.strip()
