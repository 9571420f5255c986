"""Everything a request names: frames, orbits, attitudes, targets, platforms; their scenario."""
