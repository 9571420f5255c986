"""From imaging requests to a timeline of scans and turns: what to image, when, in what order."""
