"""The solids of the study: their signed distances, and how rays intersect them."""
