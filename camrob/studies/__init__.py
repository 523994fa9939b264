"""The papers' own cases and figures. Nothing of the product needs them."""
