"""A twelfth author's sealed cases: how technicians measure."""
