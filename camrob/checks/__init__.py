"""Findings on valid data: limits, singularities, jumps, collisions."""
