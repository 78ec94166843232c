"""Laws that no catalogue holds, planted with nothing of the grammar: `docs/discovering-effects.md`."""
