"""How the sample toolpaths are made: shapes of our own, a drop-cutter, and a writer in the habits of NX CLSF."""
