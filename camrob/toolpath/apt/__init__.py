"""CL data of the APT family: one grammar, one interpreter, a dialect a CAM system."""
