"""From one state of the axes to another: line of sight, tracks, slews, and their proofs."""
