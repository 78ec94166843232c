"""``station effects``: its commands, one file each; a line here puts a command on the list."""

from station.commands import Command

COMMANDS = (
    Command("show", "Show an effect of the catalogue or of a file.", "station.commands.effects.show"),
    Command("try", "Say whether campaigns show an effect/1.", "station.commands.effects.trying"),
)
