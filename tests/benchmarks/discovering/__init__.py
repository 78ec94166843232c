"""Laws that no catalogue holds, planted with nothing of the grammar: `docs/how-to/discovering-effects.md`."""
