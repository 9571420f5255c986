"""Simulated drives and structure that a table moves."""
