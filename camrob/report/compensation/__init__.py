"""The report of a compensation."""
