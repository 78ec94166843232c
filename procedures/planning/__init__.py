"""Which campaign tells most in the least time: a linear design of placings, dwell lengths, moves and turns."""
