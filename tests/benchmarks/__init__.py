"""Benchmarks: each is a command of its own, ``python -m tests.benchmarks.NAME``."""

import os

# As `station` runs: threads of OpenBLAS wait for each other on small matrices. Set before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
