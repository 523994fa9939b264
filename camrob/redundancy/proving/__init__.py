"""Bounds that are proved: no plan is cheaper, by the planner's own price."""
