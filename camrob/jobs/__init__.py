"""The jobs behind the verbs of the command line, each one function."""
