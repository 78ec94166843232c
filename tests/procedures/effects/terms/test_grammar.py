"""What a term may say: everything else is refused with its place and the list of what there is."""

import ast
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from procedures.effects.term.effect_of_term import TermEffect
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, channel_as_written, parse
from procedures.effects.term.law import Parameter
from procedures.effects.term.units import parse_unit
from procedures.errors import ErrorCode, TermRefused
from tests.refusals import refused

W = {"w": Parameter("deg/h", 1.0, 10.0)}


def by_ours(node: Node) -> float:
    """The value of a term of numbers alone."""
    match node:
        case Number(value=value):
            return value
        case Operation(sign=sign, left=left, right=right):
            a, b = by_ours(left), by_ours(right)
            return (
                {"+": a + b, "-": a - b, "*": a * b, "/": a / b if b else math.nan}[sign] if sign != "**" else a**b
            )
    raise AssertionError(node)


numbers = st.integers(1, 9).map(str)
terms = st.recursive(
    numbers,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(" ".join),
        inner.map(lambda text: f"({text})"),
        inner.map(lambda text: f"-{text}"),
        st.tuples(inner.map(lambda text: f"({text})"), st.sampled_from(("2", "3"))).map("**".join),
    ),
    max_leaves=8,
)


@given(terms)
def test_numbers_are_what_python_makes_of_them(text: str) -> None:
    try:
        expected = eval(compile(ast.parse(text, mode="eval"), "", "eval"), {"__builtins__": {}})
    except ZeroDivisionError:
        return
    found = by_ours(parse(text))
    if isinstance(expected, int | float) and math.isfinite(found):
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_powers_bind_before_signs_and_to_the_right() -> None:
    assert by_ours(parse("-2 ** 2")) == -4
    assert by_ours(parse("2 ** 3 ** 2")) == 512
    assert parse("f(a, 1 [deg/h])") == Call("f", (Name("a", 2), Number(1.0, "deg/h", 5)), 0)


@given(st.text(max_size=60) | st.text(alphabet="u w()*+-/[]._,0e9sinlag", max_size=40))
def test_any_text_is_a_term_or_refused(text: str) -> None:
    error: TermRefused | None = None
    try:
        TermEffect("a", "gyroscope", (text,), "1", 1.0, "")
    except TermRefused as raised:
        error = raised
    assert error is None or (0 <= error.at <= len(text) and "\n" not in str(error))


OUTSIDE = (
    ("u.real", 1), ("__import__('os')", 11), ("u[0]", 1), ("lambda: 1", 6), ("eval(u)", 0), ("sinh(u / w)", 0),
    ("2 * speed", 4), ("u * (w", 6), ("u u", 2), ("", 0), ("u ** u", 5), ("u ** 99", 5),
    ("(" * 40 + "u" + ")" * 40, 30), ("u" * 501, 0), ("1e999 * u", 0), ("lag(u, t)", 0), ("lag(u)", 0),
    ("min(u)", 0), ("lag(u, 0 [s])", 7), ("u * 3 [furlong]", 7), ("u + f * w", 2), ("exp(u)", 0), ("sin(u)", 0),
    ("max(u, 1)", 0), ("u + 1", 2),
)  # fmt: skip


@pytest.mark.parametrize(("text", "at"), OUTSIDE)
def test_what_is_outside_is_refused_with_its_place(text: str, at: int) -> None:
    with refused(TermRefused, ErrorCode.TERM, f"column {at + 1} ", text=text, at=at):
        TermEffect("a", "gyroscope", (text,), "1", 1.0, "", W if "w" in text else {})


UNITS = (
    ("u", "1", "gyroscope"), ("u", "ppm", "gyroscope"), ("f", "deg/h/g", "gyroscope"),
    ("f", "rad/s/mg", "gyroscope"), ("u**2", "g/g^2", "accelerometer"), ("T_rate", "ug/(K/min)", "accelerometer"),
    ("aux_a", "g/unit", "accelerometer"), ("'aux_fan-speed 2' * T", "g/unit/K", "accelerometer"),
    ("sin(2 [rad/(deg/s)] * u)", "deg/s", "gyroscope"),
    ("sqrt(abs(u))", "g/g^0.5", "accelerometer"),
)  # fmt: skip


@pytest.mark.parametrize(("text", "unit", "triad"), UNITS)
def test_units_that_make_the_triads_output_are_taken(text: str, unit: str, triad: str) -> None:
    assert TermEffect("a", triad, (text,), unit, 1.0, "").terms == (text,)


def test_units_that_do_not_are_refused() -> None:
    with refused(TermRefused, ErrorCode.TERM, "deg/h"):
        TermEffect("a", "gyroscope", ("f",), "deg/h", 1.0, "")
    with refused(TermRefused, ErrorCode.TERM, "T"):
        TermEffect("a", "gyroscope", ("u * T",), "1/K", 1.0, "", {"T": Parameter("s", 1, 2)})
    with refused(TermRefused, ErrorCode.TERM, "[shape]"):
        TermEffect("a", "gyroscope", ("u",), "1", 1.0, "", W)


def test_a_unit_has_its_size() -> None:
    assert parse_unit("deg/h/(K/min)").size == pytest.approx(math.pi / 180 / 3600 * 60)
    assert parse_unit("ug/g^2").size == pytest.approx(1e-6)
    assert parse_unit("1/K").powers == parse_unit("ppm/K").powers
    assert parse_unit("K^-2\u00b7s").size == 1.0


def test_a_channel_of_any_name_is_written_in_quotes() -> None:
    assert parse("2 * 'aux_fan speed'").right == Name("aux_fan speed", 4)  # type: ignore[union-attr]
    for name in ("aux_a", "aux_fan-speed", "aux_fan speed", "aux_2*u", "aux_\u00b0C", "aux_[V]"):
        written = channel_as_written(name)
        assert written is not None
        assert parse(written) == Name(name, 0)
    assert channel_as_written("aux_fan") == "aux_fan"
    assert channel_as_written("aux_driver's") is None
    assert channel_as_written("aux_a\nb") is None


@pytest.mark.parametrize(
    ("text", "at"), [("'T' * u", 0), ("u * 'aux_fan", 4), ("'aux_' * u", 0), ("'aux_f'(u)", 7)]
)
def test_what_is_no_channel_in_quotes_is_refused_at_its_place(text: str, at: int) -> None:
    with refused(TermRefused, ErrorCode.TERM, at=at):
        parse(text)
