"""What the part wants: CL data and G-code as regions of tool positions, axes and feeds."""
