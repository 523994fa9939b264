"""Choosing the speed: limits along the path and its timing."""
