"""A diagnosis as people and files have it: `diagnosis/1`, its text, its plots, and the plan of what to measure next."""
