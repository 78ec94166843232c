"""A diagnosis as people and files have it: `diagnosis/2`, text, plots, and the plan of what to measure next."""
