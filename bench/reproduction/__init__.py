"""Every figure and number the papers state, ours beside theirs: docs/reproduction.md."""
