"""Generated drawings in several materials and ink, with their ground truth."""
