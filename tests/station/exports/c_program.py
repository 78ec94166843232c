"""An exported program compiled with every warning and sanitizer, and fed with samples by a pipe."""

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray

FLAGS = "-std=c99 -pedantic -O1 -Wall -Wextra -Werror -Wconversion -Wdouble-promotion -Wshadow -Wundef".split()
SANITIZED = ("-fsanitize=undefined,address", "-fno-sanitize-recover=all")
MAIN = """
#include <stdio.h>
#include <string.h>
#include "NAME.h"

int main(int argc, char **argv)
{
    static struct NAME state;
    TYPE in[8 + EXTRA], out[6];
    if (argc > 1 && strcmp(argv[1], "test") == 0) {
        printf("%.3g", (double)NAME_self_test());
        return 0;
    }
    NAME_start(&state);
    while (fread(in, sizeof in, 1, stdin) == 1) {
        SET
        NAME_apply(&state, in, in[6], in[7], out, out + 3);
        fwrite(out, sizeof out, 1, stdout);
    }
    return 0;
}
"""
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


@dataclass(frozen=True, slots=True)
class Program:
    """A compiled program of a number type, and how many inputs of its own a sample has."""

    path: Path
    number: type
    extra: int

    def apply(
        self, counts: FloatArray, T: FloatArray, dt: FloatArray, extra: FloatArray | None = None
    ) -> FloatArray:
        """Return force (n, :3) [m/s2] and rate (n, 3:) [rad/s] of counts (n, 6), T (n,) [degC] and dt (n,) [s]."""
        rows = np.column_stack((counts, T, dt, *(() if extra is None else (extra,)))).astype(self.number)
        ran = subprocess.run([self.path], input=rows.tobytes(), capture_output=True, check=False)
        assert ran.returncode == 0, ran.stderr.decode()
        return np.frombuffer(ran.stdout, self.number).reshape(-1, 6).astype(np.float64)

    def self_test(self) -> float:
        """Return what the program's own test says."""
        return float(subprocess.run([self.path, "test"], capture_output=True, check=True).stdout)


def compiled(folder: Path, name: str, *, is_float: bool, inputs: tuple[str, ...] = ()) -> Program:
    """Compile the program ``name`` in a folder; ``inputs`` are members of its state that each sample sets."""
    sets = " ".join(f"state.{each} = in[{8 + i}];" for i, each in enumerate(inputs))
    main = MAIN.replace("NAME", name).replace("TYPE", "float" if is_float else "double")
    (folder / "main.c").write_text(main.replace("EXTRA", str(len(inputs))).replace("SET", sets))
    command = ["cc", *FLAGS, *SANITIZED, f"{name}.c", "main.c", "-lm", "-o", "program"]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return Program(folder / "program", np.float32 if is_float else np.float64, len(inputs))
