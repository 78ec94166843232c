"""Where LAPACK's fast way gives up, the other one gives the same."""

import numpy as np
import pytest

from procedures.statistics.singular_values import left_singular


@pytest.mark.parametrize("shape", [(9, 4), (4, 9)])
def test_where_the_fast_way_gives_up_the_result_is_the_same(
    shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def gives_up(*_: object, **__: object) -> None:
        raise np.linalg.LinAlgError("SVD did not converge")

    A = np.random.default_rng(2).standard_normal(shape)
    U, size = left_singular(A)
    assert U.shape == (shape[0], 4)
    np.testing.assert_allclose(np.linalg.norm(A.T @ U, axis=0), size, rtol=1e-12)
    monkeypatch.setattr(np.linalg, "svd", gives_up)
    again, same = left_singular(A)
    np.testing.assert_allclose(same, size, rtol=1e-12)
    np.testing.assert_allclose(np.abs(again), np.abs(U), atol=1e-12)
