"""A reader of the little MATLAB that is exported: line by line to Python, so that it can be run without MATLAB.

Every scalar product is written ``.*``, so that ``*`` is one of matrices; names are indexed from one by a call.
What is not known here raises, and so does a line that Python does not take.
"""

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.io import loadmat

SIGNS = (
    (r"(?<![.*]) \* ", " @ "),
    (r"\.\*", "*"),
    (r"\./", "/"),
    (r"\.\^", "**"),
    ("&&", "and"),
    (r"~(?=is)", "not "),
)


class Mat(np.ndarray):
    """An array (n, m) that is indexed by a call, from one, as MATLAB does."""

    def __call__(self, *at: Any) -> "Mat":
        found = self[_place(self, at)]
        rows = at[0] if len(at) == 1 else None
        if rows is not None and self.shape[0] == 1:
            return mat(np.asarray(found).reshape(1, -1))
        return mat(np.asarray(found).reshape(-1, 1))

    def put(self, at: tuple[Any, ...], value: Any) -> None:
        flat = np.asarray(value).ravel()
        self[_place(self, at)] = flat[0] if len(flat) == 1 else flat


def _place(of: Mat, at: tuple[Any, ...]) -> Any:
    if len(at) == 2:
        return tuple(each if isinstance(each, slice) else int(each) - 1 for each in at)
    (one,) = at
    if isinstance(one, np.ndarray) and one.dtype == bool:
        return one
    numbers = np.arange(of.size) if isinstance(one, slice) else np.atleast_1d(one).ravel().astype(int) - 1
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < of.size:
        raise IndexError(f"index {numbers + 1} of {of.shape}")
    return np.unravel_index(numbers, of.shape)


def mat(value: Any) -> Mat:
    """Return a value as a matrix."""
    return np.array(value, dtype=None, ndmin=2).view(Mat)


def _row(*parts: Any) -> Mat:
    return mat(np.concatenate([np.empty(0), *(np.ravel(part) for part in parts)]).reshape(1, -1).astype(float))


NAMES: dict[str, Any] = {
    "ALL": slice(None), "mat": mat, "row": _row, "span": lambda a, b: np.arange(a, b + 1),
    "reshape": lambda x, n, m: mat(np.ravel(x)).reshape(n, m), "NaN": lambda n, m: mat(np.full((n, m), np.nan)),
    "zeros": lambda n, m: mat(np.zeros((n, m))), "repmat": lambda x, n, m: mat(np.full((n, m), float(x))),
    "isfield": lambda s, name: hasattr(s, name), "isstruct": lambda s: isinstance(s, SimpleNamespace),
    "struct": SimpleNamespace, "isfinite": np.isfinite, "numel": np.size, "sum": np.sum, "mean": np.mean,
    "min": np.minimum, "max": np.maximum, "abs": np.abs, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos,
    "sinh": np.sinh, "exp": np.exp, "log": np.log, "tanh": np.tanh, "expm1": np.expm1, "sign": np.sign,
    "norm": np.linalg.norm,
}  # fmt: skip


def functions_of(text: str) -> dict[str, Any]:
    """Return the functions of a file by name; what they give is a tuple where they give several."""
    whole = re.sub(r"\.\.\.\n\s*", " ", text)
    lines, depth, given = list[str](), 0, ""
    for number, full in enumerate(whole.splitlines(), 1):
        line = full.partition("%")[0].strip()
        if not line:
            continue
        if line in {"end", "else"} or line.startswith("elseif "):
            depth -= 1
        if line == "end":
            assert depth >= 0, f"line {number}: an end too many"
            if depth == 0:
                lines.append(f"    return {given}")
            continue
        if made := re.fullmatch(r"function (?:\[(.+)\]|(\w+)) = (\w+)\((.*)\)", line):
            assert depth == 0, f"line {number}: a function within one"
            given = made[1] or made[2]
            lines.append(f"def {made[3]}({made[4]}):")
        else:
            lines.append("    " * depth + _python(line, given, number))
        depth += line.split()[0] in {"function", "if", "elseif", "else", "for"}
    assert depth == 0, "an end is missing"
    made_of = dict(NAMES)
    exec(compile("\n".join(lines), "exported.m", "exec"), made_of)
    return made_of


def _python(line: str, given: str, number: int) -> str:
    if line == "return":
        return f"return {given}"
    if line == "else":
        return "else:"
    if found := re.fullmatch(r"(if|elseif) (.+)", line):
        return f"{'el' if found[1] == 'elseif' else ''}if {_expression(found[2])}:"
    if found := re.fullmatch(r"for (\w+) = 1:(\S+)", line):
        return f"for {found[1]} in range(int({found[2]}.item())):"
    assert line.endswith(";"), f"line {number}: no semicolon"
    target, equals, value = line[:-1].partition(" = ")
    assert equals, f"line {number}: nothing is assigned"
    if part := re.fullmatch(r"([\w.]+)\((.+)\)", target):
        return f"{part[1]}.put(({_expression(part[2])},), {_expression(value)})"
    return f"{target} = {_expression(value)}"


def _expression(text: str) -> str:
    for pattern, sign in SIGNS:
        text = re.sub(pattern, sign, text)
    text = re.sub(r"\((\d):(\d)\)", r"(span(\1, \2))", text)
    text = re.sub(r"\((\d) (\d) (\d)\)|\(\[(\d) (\d) (\d)\]\)", r"((\4, \5, \6))", text)
    text = re.sub(r"\(:, ", "(ALL, ", text).replace("(:)", "(ALL)")
    text = "ALL" if text == ":" else text
    return re.sub(r"\[(.*)\]", r"row(\1)", text)


def numbers_of(path: Any) -> SimpleNamespace:
    """Return the numbers of a .mat, as `load` does."""
    return SimpleNamespace(**{k: v if k == "samples" else mat(v) for k, v in loadmat(path).items() if k[0] != "_"})
