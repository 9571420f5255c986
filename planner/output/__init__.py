"""A plan for others: files of other tools, and columns to draw."""
