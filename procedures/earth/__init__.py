"""Gravity, the Earth rate, places on the Earth, and what shows North."""
