"""Named arrays as columns: which are taken, how they are called, and which way they lie."""

from pathlib import Path

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.logs.array_columns import array_columns

FILE = Path("log.mat")


def test_vectors_and_matrices_become_columns_a_row_a_sample() -> None:
    wide = np.arange(12.0).reshape(3, 4)  # a row a channel
    flag, one = np.array([True, False, True, True]), np.arange(4.0)[:, None]
    found = array_columns({"t": np.arange(4), "acc": wide, "flag": flag, "one": one}, FILE)
    assert {name: column.tolist() for name, column in found.items()} == {
        "t": [0.0, 1.0, 2.0, 3.0], "acc:1": [0.0, 1.0, 2.0, 3.0], "acc:2": [4.0, 5.0, 6.0, 7.0],
        "acc:3": [8.0, 9.0, 10.0, 11.0], "flag": [1.0, 0.0, 1.0, 1.0], "one": [0.0, 1.0, 2.0, 3.0],
    }  # fmt: skip
    assert all(column.flags.c_contiguous for column in found.values())


def test_a_square_matrix_lies_a_row_a_sample() -> None:
    found = array_columns({"C": [[1.0, 2.0], [3.0, 4.0]]}, FILE)
    assert found["C:1"].tolist() == [1.0, 3.0]


def test_what_is_shorter_than_the_longest_or_no_number_is_left_out() -> None:
    found = array_columns(
        {
            "t": np.arange(5), "rate": np.array(100.0), "short": np.arange(4), "text": np.array(["a"] * 5),
            "cube": np.zeros((5, 2, 2)), "empty": np.zeros(0), "complex": np.zeros(5, complex),
        },
        FILE,
    )  # fmt: skip
    assert list(found) == ["t"]


@pytest.mark.parametrize(("n", "is_taken"), [(1000, True), (1001, False)])
def test_a_matrix_of_more_than_a_thousand_columns_is_an_image(n: int, is_taken: bool) -> None:
    found = array_columns({"t": np.arange(2000), "m": np.zeros((2000, n))}, FILE)
    assert (f"m:{n}" in found) == is_taken


@pytest.mark.parametrize("arrays", [{}, {"x": np.array(["a", "b"])}, {"x": [1.0]}])
def test_without_two_rows_of_numbers_it_is_refused(arrays: dict[str, object]) -> None:
    with pytest.raises(DataRefused, match=", ".join(arrays) or "nothing"):
        array_columns(arrays, FILE)
    assert array_columns({"x": [1.0, 2.0]}, FILE)["x"].tolist() == [1.0, 2.0]
