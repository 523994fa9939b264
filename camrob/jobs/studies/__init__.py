"""The studies of papers that `camrob study NAME` runs, a function each; other verbs import them for their old words alone."""
