"""Logs from elsewhere: what their columns hold, and campaigns made of them.

`log_columns` decides what a table's columns hold, by `header_guesses` and `time_units`;
`unit_checks` holds the units against physics. `log_data` gives the columns of a step, `log_steps` its kind,
`log_campaign` a campaign. `means_table` is for tables with one row a pose.
"""
