"""Attitudes of a whole body: slews between them within its agility."""
