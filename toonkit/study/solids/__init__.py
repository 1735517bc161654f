"""The solids of the study: how they are sculpted, and how rays meet them."""
