"""Sim-to-real gaps by a fifth author: two families of other machines, procedures and descriptions."""

__all__: list[str] = []
