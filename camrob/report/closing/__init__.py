"""What a loop's ledger looks like."""
