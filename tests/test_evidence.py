"""The evidence is what proofs wrote, its page is what the files give, and every proof can be run."""

import json

import pytest

from tests.proof.evidence import EVIDENCE, FORMAT, Figure, figures, measure, write
from tests.proof.pages import PAGE, page
from tests.proof.registry import PROOFS

KEYS = ["format", "name", "shows", "commit", "date", "machine", "size", "seed", "command", "seconds", "result"]


def test_the_page_is_what_the_files_give() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "python -m tests.proof --pages"


@pytest.mark.parametrize("path", sorted(EVIDENCE.glob("*.json")), ids=lambda path: path.stem)
def test_a_file_says_what_it_is_of_and_is_of_a_proof_that_there_is(path) -> None:
    document = json.loads(path.read_text(encoding="utf-8"))
    assert list(document) == KEYS
    assert (document["format"], document["name"]) == (FORMAT, path.stem)
    assert document["shows"] == PROOFS[path.stem].shows
    assert figures(document)


@pytest.mark.parametrize("name", PROOFS)
def test_a_proof_has_its_function_and_a_quick_size(name: str) -> None:
    proof = PROOFS[name]
    assert callable(proof.run)
    assert proof.shows.endswith(".")


def test_a_number_is_met_within_what_was_asked_and_not_a_number_never_is() -> None:
    assert Figure(0.0, at_most=0).is_met
    assert not Figure(1.0, at_most=0).is_met
    assert Figure(95.0, at_least=94, at_most=96).is_met
    assert not Figure(96.5, at_least=94, at_most=96).is_met
    assert not Figure(float("nan"), at_most=1).is_met
    assert Figure(float("nan")).is_met


def test_a_proof_is_written_and_read_again(tmp_path) -> None:
    document = measure(PROOFS["hostile-mavlink"], 2000, 3)
    write(document, tmp_path / "x.json")
    found = figures(json.loads((tmp_path / "x.json").read_text(encoding="utf-8")))
    assert found["mavlink: damaged"] == Figure(2000)
    assert found["mavlink: crashes"] == Figure(0, at_most=0)
    assert document["command"] == "python -m tests.proof hostile-mavlink --size 2000 --seed 3"
