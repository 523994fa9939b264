"""Named error parameters of a cell, their identification, and compensation."""
