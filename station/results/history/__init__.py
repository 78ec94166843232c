"""What the stored calibrations say together: of a unit over time, and of all units of a model.

``tracks`` takes parameters out of calibrations, ``unit`` makes history/1, ``population`` population/1; ``text``,
``population_text`` are for the terminal, ``page``, ``figure`` and ``population_figure`` for the browser.
"""
