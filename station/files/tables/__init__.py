"""One reader of tables.

`reader` picks a format by a file's suffix: `text_table` (with `text_layout`, `text_rows`) or `binary_tables`; each
gives a `table.Table`, as a whole or in blocks. `strict_csv` reads files of this station's own
columns into the same `Table` and names the first cell that breaks their grammar.
"""
