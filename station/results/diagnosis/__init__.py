"""A diagnosis as people and files have it: `diagnosis/1`, text, plots, and the plan of what to measure next."""
