"""What is said of one, of none and of several."""

from station.text.plural import plural


def test_one_alone_is_singular() -> None:
    assert [plural(count, "gap") for count in (0, 1, 2)] == ["0 gaps", "1 gap", "2 gaps"]
    assert [plural(count, "fix") for count in (0, 1, 12)] == ["0 fixes", "1 fix", "12 fixes"]
