"""Every state that a power cut may leave on the disk, built from what the program did to its files."""
