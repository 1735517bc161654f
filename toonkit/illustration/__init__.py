"""What real drawings add to one shaded material: ink over the paint, and several materials."""
