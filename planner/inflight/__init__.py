"""What a table does in flight, and did: structure, simulated flights, telemetry."""
