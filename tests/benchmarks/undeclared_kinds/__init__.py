"""Errors of sensors from the literature, planted with nothing of the diagnosis.

`docs/explanation/undeclared.md` says which.
"""
