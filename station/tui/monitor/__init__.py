"""The screen of `station monitor`: draws a `station.monitor.view.View` and sends verbs, nothing else."""
