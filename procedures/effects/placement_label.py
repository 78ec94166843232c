"""The wrong position recorded: the cube stood in another one than its dwell says.

Not small, so no column: vectors differ by quarter and half turns. Found where a dwell fits another position
better. The coefficient is the position where it stood, so that any of 1 to 12 is plausible.
"""

from procedures.effects.effect import Effect

EFFECT = Effect(
    name="placement.label",
    unit="position",
    physics="the cube stands in position `actual`",
    source="Yao, Hu, He 2018, table 1",
    plausible=12.0,
    separate_by="the same position again",
)
