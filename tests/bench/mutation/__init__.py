"""The mutant bench: faults drawn by rule in camrob's source, and a judge of programs that shares nothing with it."""
