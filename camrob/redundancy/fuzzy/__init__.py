"""Fuzzy engines that weigh the joints: the .fis format, and the surfaces that engines are compiled to."""
