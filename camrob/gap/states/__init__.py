"""Logs of more than one state of a machine: what is another since a log, or since a moment of one."""
