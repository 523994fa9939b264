"""Proves again what a certificate says of a plan: it shares no code with the prover, nor with anything else of camrob."""
