"""Generated drawings in several materials and ink, of which everything is known."""
