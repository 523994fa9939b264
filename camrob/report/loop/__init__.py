"""The report on the tracker loop."""
