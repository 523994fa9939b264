"""An eleventh author's cases: other machines, other instruments, other tables. Nothing of camrob."""
