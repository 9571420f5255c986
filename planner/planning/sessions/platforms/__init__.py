"""The movers: what sessions ask of a platform that moves, and the answers of each kind."""
