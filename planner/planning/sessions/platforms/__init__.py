"""How the platforms of each kind move: what the sessions ask of them, and the answers by kind."""
