"""What a study says: statistics over its trials, the claims of the paper, tables and text."""
