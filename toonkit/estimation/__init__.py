"""The steps of the paper, one module each."""
