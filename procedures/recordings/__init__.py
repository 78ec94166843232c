"""What a recording's columns say of themselves before anything is estimated: the unit of time."""
