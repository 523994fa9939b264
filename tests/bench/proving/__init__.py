"""Bounds that are proved: enclosures of 1/k_F, and branch and bound over them."""
