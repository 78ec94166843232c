"""Files as the station reads and writes them: campaigns, recordings, fusion folders, fixtures, exports."""
