"""What flew against what was planned: measured shaft angles or rates beside a command table."""
