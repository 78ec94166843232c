"""What the screens are made of.

`common` is on every screen; `setup_entries` and `setup_form` are on the start screen; `step_grid`, `cube` and
`step_panels` on the campaign's.
"""
