"""numba's cache looks at the file of a kernel alone, not at those of the kernels that it calls."""

import hashlib
from pathlib import Path

import pytest

from procedures.attitude import joint_kernels
from procedures.attitude import velocity_aid_kernels as aided_kernels

HERE = Path(joint_kernels.__file__).parent
JOINT = ("kernel_options", "joint_state", "joint_strapdown", "joint_update", "joint_aids", "joint_gnss_fix")


@pytest.mark.parametrize(
    ("names", "said"), [(JOINT, joint_kernels.COMPILED_IN), (("mixer_kernels",), aided_kernels.COMPILED_IN)]
)
def test_a_changed_file_makes_its_callers_compile_again(names: tuple[str, ...], said: str) -> None:
    found = hashlib.sha256(b"".join((HERE / f"{name}.py").read_bytes() for name in names)).hexdigest()[:12]
    assert said == found, f"write COMPILED_IN = {found!r}, so that no old code stays in numba's cache"
