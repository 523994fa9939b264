"""Sim-to-real gaps by a fourth author: ordinary machines, measurements and causes, of sizes as in the literature."""

__all__: list[str] = []
