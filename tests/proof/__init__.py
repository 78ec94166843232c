"""The long statistical proofs: `make proof`, or one of them by `python -m tests.proof NAME`."""

import os

# As `station` runs: threads of OpenBLAS wait for each other on small matrices. Set before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
