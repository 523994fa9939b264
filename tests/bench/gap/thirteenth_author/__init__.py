"""The thirteenth author's sealed family: maintenance."""
