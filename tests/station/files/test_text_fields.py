"""Names and free text: what may stand on screens, pages and in names of files."""

import pytest

from station.files.text_fields import checked_name, checked_text


@pytest.mark.parametrize("name", ["FOG-3", "S0103", "Prüfling 7", "測定-1", "a.b", "x" * 64, "№ 5 (left)"])
def test_a_name_is_taken_as_it_is(name: str) -> None:
    assert checked_name(name) == name


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("", "1 to 64"), (" ", "1 to 64"), ("a ", "1 to 64"), ("x" * 65, "1 to 64"), ("../../x", "no path"),
        ("a/b", "no path"), ("C:\\x", "no path"), (".hidden", "no path"), ("a\x00b", "U+0000"), ("a\nb", "U+000A"),
        ("\x1b[31m", "U+001B"), ("\u202egnp", "U+202E"), ("a\u200bb", "U+200B"), ("a\u2028b", "U+2028"),
        ("a\ud800b", "U+D800"), ("x" * 1001, "at most 1000"),
    ],
)  # fmt: skip
def test_what_is_no_name_is_said(name: str, said: str) -> None:
    with pytest.raises(ValueError, match=said.replace("+", r"\+")):
        checked_name(name)


def test_free_text_may_be_long_and_hold_what_a_name_may_not() -> None:
    assert checked_text("1/2, see ../x " * 70) == "1/2, see ../x " * 70
    with pytest.raises(ValueError, match=r"U\+0007, U\+0008$"):
        checked_text("a\x08b\x07\x07")
