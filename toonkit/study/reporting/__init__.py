"""The report of a study: statistics over its trials, the claims of the paper, tables and text."""
