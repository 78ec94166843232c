"""Terms in the field's notation."""

import pytest

from procedures.effects.term.grammar import parse
from procedures.effects.term.latex import latex

WRITTEN = (
    ("T * T_rate", r"T\,\dot T"),
    ("f_2**2", r"f_{i+1}^{2}"),
    ("u * exp(-(u / w)**4)", r"\omega_i\,\exp\left(- \left(\frac{\omega_i}{w}\right)^{4}\right)"),
    ("lag(omega_norm**2, tau)", r"\mathrm{lag}_{\tau}\left(\lVert \omega \rVert^{2}\right)"),
    ("(f - f_before) * log(1 + t_step / 3 [s])",
     r"\left(f_i - f_i^{-}\right)\,\ln\left(1 + \frac{t_\mathrm{s}}{3\,\mathrm{s}}\right)"),
    ("sign(u) * max(0, abs(u) - w)",
     r"\operatorname{sgn}\left(\omega_i\right)\,\max\left(0, \lvert \omega_i \rvert - w\right)"),
    ("aux_fan * (T - (t - t_step) * B_x)",
     r"\mathrm{aux\_fan}\,\left(T - \left(t - t_\mathrm{s}\right)\,B_x\right)"),
    ("'aux_fan-speed 2 #%' * T", r"\mathrm{aux\_fan-speed\ 2\ \#\%}\,T"),
)  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), WRITTEN, ids=[text for text, _ in WRITTEN])
def test_a_term_is_written_as_the_field_writes_it(text: str, expected: str) -> None:
    assert latex(parse(text), "gyroscope") == expected
