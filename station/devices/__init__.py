"""What is connected: a look at ports, IMUs, receivers and cameras, recording nothing."""
