"""Material removal: what a cutter leaves of the stock, as depths along three directions."""
