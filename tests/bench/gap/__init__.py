"""The gap benchmark: cells that are wrong in known ways, their logs, sealed labels, a scorer and rivals (README.md)."""
