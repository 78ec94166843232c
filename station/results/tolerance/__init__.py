"""``station fixtures tolerance``: a cube's drawing in; a table, a figure and ``tolerance/1`` out."""
