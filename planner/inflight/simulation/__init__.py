"""What a table does to what flies it."""
