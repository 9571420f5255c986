"""What the image does when a plan's table is flown, once as planned and many times disturbed."""
