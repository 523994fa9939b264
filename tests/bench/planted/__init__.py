"""Faults planted by hand in programs that camrob wrote, by somebody who has not read the witness."""
