"""The screens of a guided calibration: they draw a `station.guide.view.View` and send `Command`s, nothing else."""
