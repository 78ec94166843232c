"""The only package that knows operators, files, time and the terminal."""

import os

# Before numpy is loaded: on matrices of some hundred rows the threads of OpenBLAS only wait for each other, on a
# busy machine many times longer than the arithmetic takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
