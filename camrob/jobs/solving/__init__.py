"""What a job hands to the solver, and what it makes of the answer."""
