"""Planned postures: freedoms, candidates, the way through them, its refinement, and the bound that it is held to."""
