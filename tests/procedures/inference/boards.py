"""Boards of plain columns, with no campaign behind them."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from procedures.inference.board import Board, Hypothesis, Option

NO_EFFECT: Any = SimpleNamespace(is_loss=False)


def board(
    y: np.ndarray,
    columns: Sequence[Sequence[np.ndarray]],
    amplitudes: np.ndarray,
    log_odds: float,
    noise_dof: float = np.inf,
) -> Board:
    """Return a board of hypotheses, each with options of columns (m, k) in equal shares."""
    evidence = cast(Any, SimpleNamespace(noise_dof=noise_dof))
    hypotheses, options, parts, width = list[Hypothesis](), list[Option](), list[np.ndarray](), 0
    for i, ways in enumerate(columns):
        hypotheses.append(Hypothesis(f"h{i}", "instrument", log_odds, amplitudes))
        for W in ways:
            options.append(Option(i, -float(np.log(len(ways))), np.arange(width, width + W.shape[1])))
            parts.append(W)
            width += W.shape[1]
    W = np.hstack([*parts, np.zeros((len(y), 1))])
    return Board(evidence, W, y, W, tuple(hypotheses), tuple(options), np.eye(len(y)))
