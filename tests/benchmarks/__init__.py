"""What the proofs of `tests.proof.registry` run."""

import tests.proof  # noqa: F401  # one thread of OpenBLAS, set before numpy is loaded
