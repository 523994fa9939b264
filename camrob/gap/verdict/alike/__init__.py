"""Names that something else may look like: a simpler or wider one, a part of a cycle, another course, what comes along."""
