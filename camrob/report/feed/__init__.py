"""The report of the welding robot's study, and the summary of `camrob feed`."""
