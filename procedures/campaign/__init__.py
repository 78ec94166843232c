"""A campaign in memory, the plan behind it, and what its steps say: rates of dwells, totals of turns."""
