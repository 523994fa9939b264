"""The command line: verbs, their options, and what all of them share."""

from camrob.cli.app import main

__all__ = ["main"]
