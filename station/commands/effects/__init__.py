"""``station effects``: its commands, one file each; a line here puts a command on the list."""

from station.commands import Command

COMMANDS = (
    Command("list", "List the user-defined error terms in force.", "station.commands.effects.listing"),
    Command("show", "Show an error term of the catalogue or of a file.", "station.commands.effects.show"),
    Command("add", "Put an error term in force for a model or a unit.", "station.commands.effects.adding"),
    Command("try", "Test whether campaigns show an error term.", "station.commands.effects.trying"),
    Command("adopt", "Write an error term of a diagnosis as a file.", "station.commands.effects.adopt"),
    Command("withdraw", "Take an error term out of force.", "station.commands.effects.withdraw"),
)
