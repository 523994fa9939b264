"""What programs that compute have in common: expressions, words with values, bounds."""
