"""Guided calibration: an engine that follows the counts, and the views that it shows.

`options` and `view` are what is asked and what is shown; `client` starts the engine's process, `server` runs
`engine` in it. `start_screen` comes before a campaign, then the folders `campaign` (recorder, database), `stages`
(what is done now) and `checks` (is it done well). `plain_screen` writes views as lines of text.
"""
