"""What the verbs say of their results: in attributes, and as the JSON objects that the contract fixes."""
