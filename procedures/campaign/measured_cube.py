"""What was measured of a cube: parallelism and skew by name, with their covariance.

Parallelism ``p_ac`` is the sum of the up tilts of face pair a along axis c, skew ``S_ac = q_ac + q_ca`` the cosine
between the mean normals of the pairs a and c (`procedures.twelve_positions.bench_parameters`). The other half of
perpendicularity, ``q_ac - q_ca``, turns the cube as a whole: nothing but the faces says where a cube's axes are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import FaceCertificate, MeasuredCube
from procedures.frames import AXES
from procedures.positions import cross_axes

PAIRS = (("x", "y"), ("x", "z"), ("y", "z"))
PARALLELISM = tuple(f"parallelism.{a}.{AXES[c]}" for a in AXES for c in cross_axes(f"{a}_up"))
SKEW = tuple(f"skew.{a}.{c}" for a, c in PAIRS)
NAMES = (*PARALLELISM, *SKEW)


@dataclass(frozen=True, slots=True, eq=False)
class UnitShare:
    """What one unit's K2 does to a measurement: ``by_quadratic`` (n, 3) [rad per g/g^2], by the unit's axes.

    ``quadratic_std`` is the 1 sigma that K2 was given, ``quadratic_left`` (3,) what the campaigns left of it.
    """

    unit: str
    by_quadratic: FloatArray
    quadratic_std: float
    quadratic_left: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CubeMeasurement:
    """A cube as IMUs measured it; ``noise`` (n, n) is the covariance without what K2 of the ``shares`` adds to it.

    ``chi2`` at ``dof``, with its p-value, says whether the units agree; ``warnings`` what is in doubt.
    """

    cube: MeasuredCube
    noise: FloatArray
    shares: tuple[UnitShare, ...]
    chi2: float = 0.0
    dof: int = 0
    p_value: float = 1.0
    warnings: tuple[str, ...] = ()


def from_tilts() -> FloatArray:
    """Return (9, 12): takes parallelism (6) and perpendicularity (6) [rad], row by face pair, to `NAMES` [rad]."""
    matrix = np.zeros((len(NAMES), 12))
    matrix[:6, :6] = np.eye(6)
    for row, (a, c) in enumerate(PAIRS, start=6):
        matrix[row, 6 + PARALLELISM.index(f"parallelism.{a}.{c}")] = 1.0
        matrix[row, 6 + PARALLELISM.index(f"parallelism.{c}.{a}")] = 1.0
    return matrix


def turning() -> FloatArray:
    """Return (3, 12): takes the tilts [rad] to ``q_ac - q_ca`` [rad], how the cube is turned as a whole."""
    matrix: FloatArray = from_tilts()[6:]
    for row, (a, c) in enumerate(PAIRS):
        matrix[row, 6 + PARALLELISM.index(f"parallelism.{c}.{a}")] = -1.0
    return matrix


def common_and_difference(names: Sequence[str]) -> tuple[tuple[str, ...], FloatArray]:
    """Return m names and the matrix (m, n), both sides in rad, of what a quadratic term can imitate and what not.

    Along each axis c the mean of the two other pairs' parallelism is the part in which ``K2`` of a sensor along c
    shows, the difference is the cube's alone; skew is taken as it is.
    """
    found, rows = list[str](), list[FloatArray]()
    for c in AXES:
        both = [f"parallelism.{a}.{c}" for a in AXES if a != c]
        if all(name in names for name in both):
            first, second = (np.eye(len(names))[list(names).index(name)] for name in both)
            found += [f"{both[0]} less {both[1]}", f"mean of {both[0]} and {both[1]}"]
            rows += [first - second, (first + second) / 2]
    skews = [name for name in names if name in SKEW]
    rows += [np.eye(len(names))[list(names).index(name)] for name in skews]
    return (*found, *skews), np.array(rows).reshape(-1, len(names))


def from_certificate(faces: Mapping[str, FaceCertificate]) -> MeasuredCube | None:
    """Return what a certificate of the faces says of `NAMES`; None where no pair has both its faces in it.

    p is the sum of a pair's up tilts, q half their difference.
    """
    pairs = [a for a in AXES if f"{a}_up" in faces and f"{a}_down" in faces]
    if not pairs:
        return None
    value, covariance = np.zeros(12), np.zeros((12, 12))
    for a in pairs:
        at = 2 * AXES.index(a)
        up, down = faces[f"{a}_up"], faces[f"{a}_down"]
        take = np.block([[np.eye(2), np.eye(2)], [np.eye(2) / 2, -np.eye(2) / 2]])
        both = np.block([[up.covariance, np.zeros((2, 2))], [np.zeros((2, 2)), down.covariance]])
        rows = [at, at + 1, 6 + at, 7 + at]
        value[rows] = take @ np.concatenate((up.up_tilt, down.up_tilt))
        covariance[np.ix_(rows, rows)] = take @ both @ take.T
    known = [all(part in pairs for part in _pairs_of(name)) for name in NAMES]
    G = from_tilts()[known]
    names = tuple(name for name, it_is in zip(NAMES, known, strict=True) if it_is)
    return MeasuredCube(names, G @ value, G @ covariance @ G.T)


def _pairs_of(name: str) -> str:
    """Return the face pairs a value of `NAMES` is made of."""
    kind, a, c = name.split(".")
    return a if kind == "parallelism" else a + c
