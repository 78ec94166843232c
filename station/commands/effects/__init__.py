"""``station effects``: its commands, one file each; a line here puts a command on the list."""

from station.commands import Command

COMMANDS = (
    Command("list", "List the effects of one's own in force.", "station.commands.effects.listing"),
    Command("show", "Show an effect of the catalogue or of a file.", "station.commands.effects.show"),
    Command("add", "Put an effect/1 in force for a model or a unit.", "station.commands.effects.adding"),
    Command("try", "Say whether campaigns show an effect/1.", "station.commands.effects.trying"),
    Command("adopt", "Write an effect of a diagnosis as an effect/1.", "station.commands.effects.adopt"),
    Command("withdraw", "Take an effect out of force.", "station.commands.effects.withdraw"),
)
