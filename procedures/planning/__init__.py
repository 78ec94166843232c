"""Which campaign determines most in the least time: a linear design of placements, dwells and rotations.

`campaign_design` (a plan), `placement_rows` and `step_information` (what each step adds), `design_sigmas` (the
uncertainties that follow), `order_search` and `least_time` (the best plan), `identifiability` (of error terms).
"""
