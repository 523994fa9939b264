"""Readers of the programs of Siemens and Heidenhain."""
