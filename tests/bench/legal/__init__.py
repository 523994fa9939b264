"""Legal CL files drawn at random, in several dialects, each with the story of what must come out."""
