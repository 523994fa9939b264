"""The report of a predicted part."""
