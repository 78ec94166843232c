"""The calibration: what is asked of the operator, what was observed, and the solution."""
