"""The screen of `station monitor`: draws a `station.monitor.view.MonitorView` and sends verbs, nothing else."""
