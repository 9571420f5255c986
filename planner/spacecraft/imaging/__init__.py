"""From imaging requests to a timeline of scans and slews: what to image, when, in what order."""
