"""CAN: received frames as a stream of checked records, and counts described by a DBC and a mapping file."""
