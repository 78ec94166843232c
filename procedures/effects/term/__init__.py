"""The equation of an effect as terms, written once.

A text is parsed by `grammar` (`functions`, `units`) and checked by `dimensions`; `inputs` are what it may name and
`values` what it is at the nodes of a campaign. A `law` is a sum of terms, from which columns, correction, exports
and `latex` are made; `effect_of_term` makes an effect of one that a user wrote.
"""
