"""Locating a fusion folder: a source, the outer graph, and what is written of them."""
