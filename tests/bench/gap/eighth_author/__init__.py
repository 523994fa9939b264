"""An eighth author's sealed cases: see README.md."""
