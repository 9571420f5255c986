"""Two axes on a carrier: their slews, tracks and pointing budget."""
