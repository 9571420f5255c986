"""The horizon found in frames: candidates by vote, each fitted and judged."""
