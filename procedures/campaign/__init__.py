"""A campaign in memory, and what its steps say.

`plan_steps` (what the operator is asked to do), `campaign` (what was recorded), `measured_cube` (its fixture),
`dead_channels` (channels to exclude), `observations` (rates of dwells, totals of rotations, with uncertainty).
"""
