"""Sim-to-real gaps by a second author: cells, causes and leftovers from physics, apart from the library and its benchmark."""
