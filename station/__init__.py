"""The only package that knows operators, files, time and the terminal."""
