"""One thread of OpenBLAS a process, as `station` has it; set before a test module loads numpy."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
