r"""A term in the field's notation, as LaTeX: f_i, \omega_i, T, \dot T, with indices of the three axes in turn."""

import re

from procedures.effects.term.grammar import Call, Name, Node, Number, Operation
from procedures.effects.term.law import Law

INPUTS = {
    "T": "T", "T_rate": r"\dot T", "t": "t", "t_step": r"t_\mathrm{s}", "f_before": r"f_i^{-}", "north": "n_i",
    "east": "e_i", "out": r"\tilde u_i", "pi": r"\pi", "tau": r"\tau", "tau_s": r"\tau", "play_k": "w",
    "knee_deg_s": "w", "warming": "d", "t_on": "t", "t_rest": r"t_\mathrm{s}",
    "out_changing": r"\tilde u_i", "c": "c",
}  # fmt: skip
AXES = {"": "i", "_2": "{i+1}", "_3": "{i+2}", "_x": "x", "_y": "y", "_z": "z"}
VECTORS = {"f": "f", "omega": r"\omega", "B": "B", "vibration": r"\sigma^2"}
CALLS = {"exp": r"\exp", "log": r"\ln", "sin": r"\sin", "cos": r"\cos", "tanh": r"\tanh", "min": r"\min",
         "max": r"\max", "sign": r"\operatorname{sgn}", "backlash": r"\mathrm{backlash}",
         "sine": r"\mathrm{sine}"}  # fmt: skip
SUM, PRODUCT, POWER = 1, 2, 3  # how closely a node's parts hold together


def latex(node: Node, triad: str) -> str:
    """Return a term of a triad's sensor i; ``T`` counts from 25 degC."""
    return _Writer(triad).written(node, 0)


class _Writer:
    def __init__(self, triad: str) -> None:
        self.own = "f" if triad == "accelerometer" else r"\omega"

    def written(self, node: Node, within: int) -> str:
        match node:
            case Number(value=value, unit=unit):
                return f"{value:g}" + (rf"\,\mathrm{{{unit}}}" if unit else "")
            case Name(name=name):
                return self.named(name)
            case Call():
                return self.called(node)
            case Operation():
                return self.operation(node, within)

    def named(self, name: str) -> str:
        if name == "u":
            return f"{self.own}_i"
        for vector, symbol in VECTORS.items():
            if name == f"{vector}_norm":
                return rf"\lVert {symbol} \rVert"
            if name.startswith(vector) and name.removeprefix(vector) in AXES:
                return f"{symbol}_{AXES[name.removeprefix(vector)]}"
        plain = re.sub(r"[\\^~]", "-", name)  # an auxiliary channel's own
        plain = re.sub(r"([_#$%&{}])", r"\\\1", plain).replace(" ", r"\ ")
        return INPUTS.get(name, name if len(name) == 1 else rf"\mathrm{{{plain}}}")

    def called(self, node: Call) -> str:
        each = [self.written(argument, 0) for argument in node.arguments]
        match node.name:
            case "abs":
                return rf"\lvert {each[0]} \rvert"
            case "sqrt":
                return rf"\sqrt{{{each[0]}}}"
            case "lag" | "smooth":
                sign = r"\mathrm{lag}" if node.name == "lag" else r"\mathrm{mean}"
                return rf"{sign}_{{{each[1]}}}\left({each[0]}\right)"
        return rf"{CALLS[node.name]}\left({', '.join(each)}\right)"

    def operation(self, node: Operation, within: int) -> str:
        match node.sign:
            case "/":
                text = rf"\frac{{{self.written(node.left, 0)}}}{{{self.written(node.right, 0)}}}"
                return rf"\left({text}\right)" if within == POWER else text
            case "**":
                return f"{self.written(node.left, POWER)}^{{{self.written(node.right, 0)}}}"
            case "*":
                text = rf"{self.written(node.left, PRODUCT)}\,{self.written(node.right, PRODUCT)}"
                return self.held(text, PRODUCT, within)
        left = "" if isinstance(node.left, Number) and node.left.value == 0 else self.written(node.left, SUM)
        right = self.written(node.right, PRODUCT if node.sign == "-" else SUM)
        return self.held(f"{left} {node.sign} {right}".strip(), SUM, within)

    def held(self, text: str, own: int, within: int) -> str:
        return rf"\left({text}\right)" if own < within else text


def latex_of_law(law: Law) -> str:
    """Return what a law adds, in the field's notation; coefficients c, or c_1, c_2, ..."""
    texts = [latex(node, law.triad) for node in law.nodes(2)]
    if law.is_inside:
        return texts[0]
    several = len(texts) > 1
    parts = [rf"c_{{{i}}}\,{part}" if several else rf"c\,{part}" for i, part in enumerate(texts, 1)]
    return " + ".join(parts) + (r" + \dots" if law.is_polynomial else "")
