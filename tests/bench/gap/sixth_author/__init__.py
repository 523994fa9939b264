"""A sixth author's sealed families of sim-to-real gaps, from numpy and scipy alone."""
