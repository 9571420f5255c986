"""The table in flight: structure, simulated flights, telemetry."""
