"""The report of a derivative analysis."""
