"""Telemetry against the plan: measured shaft angles or rates beside a command table."""
