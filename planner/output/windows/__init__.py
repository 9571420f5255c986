"""Windows as they are told: rows of JSON, and forms for maps and tables."""
