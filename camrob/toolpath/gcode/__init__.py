"""G-code: one reader of blocks, modes, motions and cycles."""
