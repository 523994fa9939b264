"""What was mixed up in a log that can't be of its cell, each mistake tried alone."""
