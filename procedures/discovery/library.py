"""The library: products of up to three inputs, functions of one input times products of two, waves, matrices.

Terms of ten thousand are made from the arrays of some hundred factors, never parsed one by one; the few that come
into question are then written as `TermEffect`, which checks their units.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.discovery.factors import (
    Factor,
    Shape,
    inputs_seen,
    shapes_of_input,
    shapes_of_time,
    shapes_of_vector,
    waves,
)
from procedures.effects.excitation import Excitation
from procedures.effects.term.effect_of_term import TermEffect
from procedures.effects.term.law import Parameter
from procedures.evidence.residual_rows import Evidence
from procedures.evidence.row_sums import NodeWeights
from procedures.frames import AXES, TRIADS

COEFFICIENT = {"accelerometer": "ug", "gyroscope": "deg/h"}
DEGREE = 3  # of a product of inputs
OF_A_POWER = 0.5  # of a factor: how much more complex a square or a cube is
PER_BLOCK = 100  # products whose values at the nodes are held at a time
NODES = 2048  # whose values are held at a time, or those of one step where it has more: they stay in the cache
Product = tuple[Factor, ...]


@dataclass(frozen=True, slots=True)
class LibraryTerm:
    """A term of a triad: one product of factors, or several with a coefficient each; the same for all sensors."""

    triad: str
    products: tuple[Product, ...]
    shape: Mapping[str, Shape] = field(default_factory=dict)

    @property
    def texts(self) -> tuple[str, ...]:
        """Its products in the grammar."""
        return tuple(map(_text, self.products))

    @property
    def weight(self) -> float:
        """How complex it is: different factors, parameters, powers, products."""
        return max(map(_weight, self.products)) + len(self.products) - 1

    @property
    def key(self) -> tuple[str, tuple[str, ...]]:
        """What it is but for its parameter's value."""
        return self.triad, self.texts

    def as_effect(self, name: str, plausible: float, source: str) -> TermEffect:
        """Return it as `effect/1` has it, its parameter to be fitted."""
        units = [factor.unit for factor in self.products[0] if factor.unit]
        unit = COEFFICIENT[self.triad] + "".join(f"/({each})" if "/" in each else f"/{each}" for each in units)
        shape = {key: Parameter(one.unit, one.low, one.high) for key, one in self.shape.items()}
        return TermEffect(name, self.triad, self.texts, unit, plausible, source, shape)


def library(seen: Excitation, triads: Sequence[str] = TRIADS) -> list[LibraryTerm]:
    """Return every term that may have acted in a campaign."""
    return [term for triad in triads for term in _of_triad(seen, triad)]


def _of_triad(seen: Excitation, triad: str) -> Iterator[LibraryTerm]:
    inputs = inputs_seen(seen, triad)
    pairs = [*_products(inputs, 1), *_products(inputs, 2)]
    for product in (*pairs, *_products(inputs, DEGREE)):
        yield LibraryTerm(triad, (product,))
    change = Factor("(f - f_before)", "g", 1)
    for shape in shapes_of_time(seen, triad):
        for product in ((), (change,), *pairs):
            yield LibraryTerm(triad, ((*product, shape),), shape.shape)
    by_scalar = [(), *((one,) for one in inputs if one.text in {"T", "T_rate", "t"})]
    for shape in shapes_of_input(seen, triad):
        for product in by_scalar:
            yield LibraryTerm(triad, ((*product, shape),), shape.shape)
    for one in inputs:
        if one.text.startswith(("f_2", "f_3", "omega_", "B")) or (one.text == "f" and triad == "gyroscope"):
            for product in by_scalar:
                yield from (LibraryTerm(triad, ((*product, shape),)) for shape in shapes_of_vector(one))
    for sine, cosine in waves(seen, triad):
        # a wave of the input times the input is a bend of any shape, with another scale factor
        others = {"u", "f", "T"} - ({"u"} if " u " in sine.text else set())
        for product in ((), *((one,) for one in inputs if one.text in others)):
            yield LibraryTerm(triad, ((*product, sine), (*product, cosine)), sine.shape)
    yield from _matrices(triad, {one.text: one for one in inputs})


def _products(inputs: Sequence[Factor], degree: int) -> Iterator[Product]:
    return iter(itertools.combinations_with_replacement(inputs, degree))


def _matrices(triad: str, by_name: Mapping[str, Factor]) -> Iterator[LibraryTerm]:
    """Yield what takes a vector by a matrix of any nine numbers, and the squares and products of one."""
    for vector in (["f", "f_2", "f_3"], ["B", "B_2", "B_3"], ["u", "omega_2", "omega_3"]):
        if triad == "accelerometer":
            vector = ["u" if each == "f" else each for each in vector]
        if not all(each in by_name for each in vector):
            continue
        a, b, c = (by_name[each] for each in vector)
        yield LibraryTerm(triad, ((a,), (b,), (c,)))
        yield LibraryTerm(triad, ((a, a), (b, b)))
        yield LibraryTerm(triad, ((a, b), (b, c), (a, c)))
        yield LibraryTerm(triad, ((a, a), (b, b), (a, b), (b, c), (a, c)))


def _weight(product: Product) -> float:
    once = {factor.text: factor.weight for factor in product}
    return sum(once.values()) + OF_A_POWER * (len(product) - len(once))


def _text(product: Product) -> str:
    counts = dict[str, int]()
    for factor in product:
        counts[factor.text] = counts.get(factor.text, 0) + 1
    return " * ".join(text if n == 1 else f"{text}**{n}" for text, n in counts.items())


class Rows:
    """Makes the rows of terms in sigmas; the values of factors are worked out once."""

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self._known = dict[tuple[str, str, tuple[float, ...]], FloatArray]()
        self._weights = {name: _joined(evidence, number) for number, name in enumerate(TRIADS)}

    def of(self, terms: Sequence[LibraryTerm]) -> FloatArray:
        """Return columns (n, t, 3 m) in sigmas of terms (t,) of a triad, m products each: by product, sensor."""
        m, triad = len(terms[0].products), terms[0].triad
        products = [product for term in terms for product in term.products]
        H = np.zeros((len(self.evidence.residual), len(products), len(AXES)))
        for begin in range(0, len(products), PER_BLOCK):
            block = products[begin : begin + PER_BLOCK]
            factors = [[self._factor(triad, factor) for factor in product] for product in block]
            for nodes, weights in self._weights[triad][1]:
                values = _products_at(factors, nodes)
                self._add(H[:, begin : begin + len(block)], values, weights, nodes.start)
        H /= self.evidence.sigma[:, None, None]
        return H.reshape(len(H), len(terms), m * len(AXES))

    def _factor(self, triad: str, factor: Factor) -> FloatArray:
        key = triad, factor.text, tuple(one.value for one in factor.shape.values())
        if key not in self._known:
            value = factor.values(self.evidence.excitation, triad)
            self._known[key] = value[self._weights[triad][0]] if len(value) > 1 else value
        return self._known[key]

    def _add(
        self, H: FloatArray, values: FloatArray, weights: Sequence[tuple[NodeWeights, slice]], first: int
    ) -> None:
        """Add to rows (n, k, 3) what values (k, nodes, 3) from node ``first`` on make of them."""
        for each, at in weights:
            here = values[:, at.start - first : at.stop - first]
            if each.move is not None:
                matrix = each.move.matrix.reshape(len(AXES), -1, len(AXES))
                of_sensors = [here[:, :, j] @ matrix[:, :, j].T for j in range(len(AXES))]  # (k, rows)
                H[each.rows] += np.stack(of_sensors, axis=2).swapaxes(0, 1)
                continue
            part = each.w @ here  # (k, 3)
            mix = np.eye(len(AXES)) if each.mix is None else each.mix
            H[each.rows] += mix[:, None, :] * part


def _products_at(factors: Sequence[Sequence[FloatArray]], nodes: slice) -> FloatArray:
    """Return the products (k, nodes, 3) of factors (n, 3), (n, 1) or (1, ...) at some nodes."""
    found = np.ones((len(factors), nodes.stop - nodes.start, len(AXES)))
    for value, several in zip(found, factors, strict=True):
        for factor in several:
            value *= factor[nodes] if len(factor) > 1 else factor
    return found


Together = tuple[slice, list[tuple[NodeWeights, slice]]]
"""Nodes, and the weightings that make rows of them, each with its own."""


def _joined(evidence: Evidence, triad: int) -> tuple[IntArray, list[Together]]:
    """Return the nodes that the rows of a triad are made of, and by some steps together where among them."""
    nodes, places, count = list[IntArray](), list[Together](), 0
    by_nodes = dict[tuple[int, int], list[NodeWeights]]()
    for each in evidence.weights:
        if each.triad == triad:
            by_nodes.setdefault((each.nodes.start, each.nodes.stop), []).append(each)
    for key, several in by_nodes.items():
        nodes.append(np.arange(*key))
        here = slice(count, count := count + len(nodes[-1]))
        weights = [(each, here) for each in several]
        if places and count - places[-1][0].start <= NODES:
            places[-1] = slice(places[-1][0].start, count), [*places[-1][1], *weights]
        else:
            places.append((here, weights))
    return np.concatenate(nodes) if nodes else np.zeros(0, dtype=np.int64), places
